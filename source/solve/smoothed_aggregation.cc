// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "smoothed_aggregation.h"

#include <Epetra_ConfigDefs.h>
#include <Teuchos_ParameterList.hpp>
#include <ml_MultiLevelPreconditioner.h>
#include <ml_epetra_utils.h>
#include <ml_include.h>

#include <algorithm>

namespace dovetail {

namespace {

/// Whether the rows of @p n components of a vector field follow each other, node by node: row i sees no
/// translation but that of component i % n. Each set of modes begins with the translations.
bool are_rows_by_node(const Epetra_MultiVector &modes, const int n)
{
  const int n_of_set = n * (n + 1) / 2; // with rotations
  int here = modes.NumVectors() % n_of_set == 0 && modes.MyLength() % n == 0;
  for (int mode = 0; here && mode < modes.NumVectors(); ++mode)
    for (int row = 0; mode % n_of_set < n && row < modes.MyLength(); ++row)
      here = here && (mode % n_of_set == row % n || modes[mode][row] == 0);
  int everywhere = 0;
  modes.Comm().MinAll(&here, &everywhere, 1);
  return everywhere != 0;
}

/// For aggregates that do not cut nodes.
int rows_per_node(const Epetra_MultiVector &modes)
{
  for (const int n : {3, 2})
    if (are_rows_by_node(modes, n))
      return n;
  return 1;
}

Teuchos::ParameterList parameters_of_ml(const Epetra_MultiVector &modes)
{
  Teuchos::ParameterList list;
  ML_Epetra::SetDefaults("SA", list);
  list.set("ML output", 0);
  list.set("aggregation: type", "Uncoupled");
  list.set("aggregation: threshold", 0.0);  // a positive one drops the couplings of a stiff with a soft body
  list.set("smoother: type", "do-nothing"); // set_smoothers
  list.set("coarse: type", "Amesos-KLU");
  list.set("coarse: max size", 2000);
  list.set("PDE equations", rows_per_node(modes));
  list.set("null space: type", "pre-computed");
  list.set("null space: dimension", modes.NumVectors());
  static double none = 0;
  list.set("null space: vectors", modes.MyLength() > 0 ? modes.Values() : &none); // ML refuses a null pointer
  return list;
}

/// What ML calls on a level.
int smooth_level(ML_Smoother *level, int, double x[], int, double b[])
{
  static_cast<const ChebyshevSmoother *>(ML_Get_MySmootherData(level))
      ->smooth(x, b, level->init_guess == ML_ZERO);
  return 0;
}

} // namespace

std::unique_ptr<Epetra_MultiVector> make_modes(const GroupFacts &facts, const Epetra_Map &rows)
{
  const auto near_null_space = facts.near_null_space();
  auto modes = std::make_unique<Epetra_MultiVector>(rows, near_null_space.size());
  for (unsigned int mode = 0; mode < near_null_space.size(); ++mode)
    std::copy(near_null_space[mode].begin(), near_null_space[mode].end(), (*modes)[mode]);
  return modes;
}

SmoothedAggregation::SmoothedAggregation(const Epetra_CrsMatrix &A, const Epetra_MultiVector &modes,
                                         const MakeSmoother &make_smoother)
    : levels(std::make_unique<ML_Epetra::MultiLevelPreconditioner>(A, parameters_of_ml(modes)))
{
  set_smoothers(A, make_smoother);
}

SmoothedAggregation::~SmoothedAggregation() = default;

void SmoothedAggregation::set_smoothers(const Epetra_CrsMatrix &A, const MakeSmoother &make_smoother)
{
  ML &ml = *const_cast<ML *>(levels->GetML()); // hands out no other
  const int to_coarser = ml.ML_finest_level < ml.ML_coarsest_level ? 1 : -1;
  for (int level = ml.ML_finest_level; level != ml.ML_coarsest_level; level += to_coarser) {
    const Epetra_CrsMatrix *matrix = &A;
    if (level != ml.ML_finest_level) {
      Epetra_CrsMatrix *copy = nullptr;
      ML_Operator2EpetraCrsMatrix(&ml.Amat[level], copy);
      coarse_matrices.emplace_back(copy);
      matrix = copy;
    }
    smoothers.push_back(make_smoother(*matrix));
    ML_Set_Smoother(&ml, level, ML_BOTH, smoothers.back().get(), smooth_level,
                    const_cast<char *>("Chebyshev"));
  }
}

void SmoothedAggregation::vmult(Epetra_MultiVector &x, const Epetra_MultiVector &b) const
{
  levels->ApplyInverse(b, x);
}

} // namespace dovetail
