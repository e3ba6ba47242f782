// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// CG or GMRES with ML's smoothed aggregation, for a symmetric group of a degree above one after a first
// coarsening to the functions of degree one (degree_coarsening.h).
//
//     subsection Linear solver
//       set Type = multigrid
//     end
//
// P. Vanek, J. Mandel, M. Brezina: Algebraic multigrid by smoothed aggregation for second and fourth order
// elliptic problems, 1996.

#include "degree_coarsening.h"

#include <dovetail/solve/krylov.h>

#include <deal.II/lac/trilinos_precondition.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_MultiVector.h>
#include <Teuchos_ParameterList.hpp>

#include <algorithm>
#include <memory>

namespace dovetail {

class Multigrid : public GroupSolver
{
public:
  Multigrid(const Section &, const GroupFacts &facts) : facts(facts) {}

  std::string description() const override { return describe_iteration(facts, "multigrid"); }
  void prepare(const GroupOperator &K, const Agreement &ranks) override;
  unsigned int solve(const GroupOperator &K, GroupVector &x, const GroupVector &b, double goal) override;
  void forget() override
  {
    multigrid.reset();
    by_degree.reset();
    modes.reset();
  }

private:
  void make_modes(const Epetra_CrsMatrix &matrix);
  void make_multigrid(const Epetra_CrsMatrix &matrix);

  const GroupFacts &facts;
  std::unique_ptr<Epetra_MultiVector> modes; ///< ML refers to them
  std::unique_ptr<dealii::TrilinosWrappers::PreconditionAMG> multigrid;
  std::unique_ptr<DegreeCoarsening> by_degree; ///< instead, for a degree above one
};

void Multigrid::prepare(const GroupOperator &K, const Agreement &ranks)
{
  multigrid.reset();
  by_degree.reset();
  const Epetra_CrsMatrix &matrix = *K.bodies().matrix();
  ranks.run("modes", [&]() { make_modes(matrix); });
  ranks.run("multigrid", [&]() { make_multigrid(matrix); });
}

/// They stay the same while the values of the matrix change.
void Multigrid::make_modes(const Epetra_CrsMatrix &matrix)
{
  if (modes)
    return;
  const auto near_null_space = facts.near_null_space();
  modes = std::make_unique<Epetra_MultiVector>(matrix.OperatorDomainMap(), near_null_space.size());
  for (unsigned int mode = 0; mode < near_null_space.size(); ++mode)
    std::copy(near_null_space[mode].begin(), near_null_space[mode].end(), (*modes)[mode]);
}

void Multigrid::make_multigrid(const Epetra_CrsMatrix &matrix)
{
  const bool coarsens_degree = facts.degree > 1 && facts.is_symmetric && facts.linear_part;
  dealii::TrilinosWrappers::PreconditionAMG::AdditionalData data;
  data.elliptic = facts.is_symmetric;
  data.higher_order_elements = facts.degree > 1 && !coarsens_degree;
  data.smoother_sweeps = 2;
  data.smoother_type = facts.is_symmetric ? "Chebyshev" : "ILU";
  Teuchos::ParameterList list;
  std::unique_ptr<Epetra_MultiVector> unused;
  data.set_parameters(list, unused, matrix);
  list.set("null space: type", "pre-computed");
  list.set("null space: dimension", modes->NumVectors());
  list.set("null space: vectors", modes->Values());
  list.set("aggregation: threshold", 0.0); // a positive one drops the couplings of a stiff with a soft body
  if (coarsens_degree) {
    by_degree = std::make_unique<DegreeCoarsening>(matrix, facts.linear_part(), *modes, list);
    return;
  }
  multigrid = std::make_unique<dealii::TrilinosWrappers::PreconditionAMG>();
  multigrid->initialize(matrix, list);
}

unsigned int Multigrid::solve(const GroupOperator &K, GroupVector &x, const GroupVector &b, const double goal)
{
  const auto cycle = [this](GroupVector &z, const GroupVector &r) {
    by_degree ? by_degree->vmult(z, r) : multigrid->vmult(z, r);
  };
  return solve_by_iteration(K, facts, cycle, x, b, goal);
}

namespace {
[[maybe_unused]] const bool registered = SolverCatalogue::add<Multigrid>(
    "multigrid", "ML as preconditioner of CG, or of GMRES if the group is not symmetric or has multipliers.");
}

} // namespace dovetail
