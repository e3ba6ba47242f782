// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// CG or GMRES with smoothed aggregation, for a degree above one after a first coarsening to the functions of
// degree one. A group that is not symmetric is preconditioned by the symmetric part of its matrix.
//
// At degree one the smoothers are made of the diagonal, until an iteration is slow: then, and from then on,
// of incomplete factorisations, which cost more and smooth what stretched cells and the like leave.
//
//     subsection Linear solver
//       set Type = multigrid
//     end

#include "degree_coarsening.h"

#include <dovetail/solve/krylov.h>

#include <deal.II/lac/solver_control.h>

#include <EpetraExt_Transpose_RowMatrix.h>
#include <Epetra_CrsMatrix.h>
#include <Epetra_Import.h>
#include <Epetra_IntVector.h>
#include <Epetra_MultiVector.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>

namespace dovetail {

class Multigrid : public GroupSolver
{
public:
  Multigrid(const Section &, const GroupFacts &facts) : facts(facts) {}

  std::string description() const override { return describe_iteration(facts, "multigrid"); }
  void prepare(const GroupOperator &K, const Agreement &all_ranks) override;
  unsigned int solve(const GroupOperator &K, GroupVector &x, const GroupVector &b, double goal) override;
  void forget() override
  {
    forget_values();
    modes.reset();
    is_slow = false;
  }

private:
  void forget_values();
  void make_aggregation();
  void make_modes(const Epetra_CrsMatrix &matrix);
  void make_levels();
  unsigned int iterate(const GroupOperator &K, GroupVector &x, const GroupVector &b, double goal,
                       const std::function<bool(unsigned int n, double r)> &gives_up);

  const GroupFacts &facts;
  Agreement ranks;
  std::unique_ptr<Epetra_MultiVector> modes;
  std::unique_ptr<Epetra_CrsMatrix> symmetric_part; ///< of a matrix that is not symmetric
  const Epetra_CrsMatrix *matrix = nullptr;         ///< that is preconditioned
  bool is_slow = false;                             ///< with smoothers made of the diagonal
  std::unique_ptr<SmoothedAggregation> aggregation;
  std::unique_ptr<DegreeCoarsening> by_degree; ///< instead, for a degree above one
};

/// (A + A^T) / 2 within each field, and nothing between fields, whose units differ: what is left is positive
/// definite if the fields are by themselves. An entry without a partner across the diagonal is left out too.
std::unique_ptr<Epetra_CrsMatrix> make_symmetric_part(const Epetra_CrsMatrix &A,
                                                      const std::vector<int> &field_of_row)
{
  EpetraExt::RowMatrix_Transpose transposer;
  const auto &transposed = dynamic_cast<Epetra_CrsMatrix &>(transposer(const_cast<Epetra_CrsMatrix &>(A)));
  const Epetra_IntVector row_field(Copy, A.RowMap(), const_cast<int *>(field_of_row.data()));
  Epetra_IntVector column_field(A.ColMap());
  column_field.Import(row_field, Epetra_Import(A.ColMap(), A.RowMap()), Insert);

  auto sum = std::make_unique<Epetra_CrsMatrix>(Copy, A.Graph()); // the same graph, held once
  std::vector<double> partner(A.NumMyCols());                     // by column, of one row; NaN: none
  for (int row = 0; row < A.NumMyRows(); ++row) {
    int n = 0, n_transposed = 0, *columns = nullptr, *transposed_columns = nullptr;
    double *values = nullptr, *transposed_values = nullptr, *result = nullptr;
    A.ExtractMyRowView(row, n, values, columns);
    transposed.ExtractMyRowView(row, n_transposed, transposed_values, transposed_columns);
    sum->ExtractMyRowView(row, n, result);
    for (int k = 0; k < n; ++k)
      partner[columns[k]] = std::numeric_limits<double>::quiet_NaN();
    for (int k = 0; k < n_transposed; ++k)
      if (const int column = A.LCID(transposed.GCID(transposed_columns[k])); column >= 0)
        partner[column] = transposed_values[k];
    for (int k = 0; k < n; ++k) {
      const bool is_left_out = std::isnan(partner[columns[k]]) || column_field[columns[k]] != row_field[row];
      result[k] = is_left_out ? 0 : (values[k] + partner[columns[k]]) / 2;
    }
  }
  return sum;
}

void Multigrid::forget_values()
{
  aggregation.reset();
  by_degree.reset();
  symmetric_part.reset();
}

void Multigrid::prepare(const GroupOperator &K, const Agreement &all_ranks)
{
  forget_values();
  ranks = all_ranks;
  matrix = K.bodies().matrix();
  ranks.run("modes", [&]() { make_modes(*matrix); });
  if (!facts.is_symmetric) {
    ranks.run("symmetric part",
              [&]() { symmetric_part = make_symmetric_part(*matrix, facts.field_of_row()); });
    matrix = symmetric_part.get();
  }
  ranks.run("multigrid", [&]() { make_levels(); });
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

void Multigrid::make_levels()
{
  if (facts.degree > 1 && facts.linear_part)
    by_degree = std::make_unique<DegreeCoarsening>(*matrix, facts.linear_part(), *modes);
  else
    make_aggregation();
}

void Multigrid::make_aggregation()
{
  aggregation.reset();
  aggregation = std::make_unique<SmoothedAggregation>(*matrix, *modes, [this](const auto &level) {
    return is_slow ? ChebyshevSmoother::with_factorisation(level, {4, 40})
                   : ChebyshevSmoother::with_diagonal(level, {2, 10});
  });
}

unsigned int Multigrid::solve(const GroupOperator &K, GroupVector &x, const GroupVector &b, const double goal)
{
  if (is_slow || by_degree || facts.has_multipliers) // whose Schur complement may be what is slow
    return iterate(K, x, b, goal, {});

  const unsigned int n_between_checks = 8, most_iterations = 30;
  const double decades = std::log10(b.l2_norm() / goal);
  const auto will_take_too_many = [&](const unsigned int n, const double residual) {
    return n > 0 && n % n_between_checks == 0 &&
           n * decades > most_iterations * std::log10(b.l2_norm() / residual);
  };
  unsigned int n_iterations = 0;
  try {
    return iterate(K, x, b, goal, will_take_too_many);
  } catch (const dealii::SolverControl::NoConvergence &end) { // on all ranks
    n_iterations = end.last_step;
  }
  is_slow = true;
  ranks.run("multigrid", [this]() { make_aggregation(); });
  GroupVector residual(b), correction(K.vector());
  K.vmult(residual, x);
  residual.sadd(-1., 1., b);
  if (!(residual.l2_norm() < b.l2_norm())) {
    x = 0;
    residual = b;
  }
  n_iterations += iterate(K, correction, residual, goal, {});
  x += correction;
  return n_iterations;
}

unsigned int Multigrid::iterate(const GroupOperator &K, GroupVector &x, const GroupVector &b,
                                const double goal,
                                const std::function<bool(unsigned int n, double r)> &gives_up)
{
  const auto cycle = [this](GroupVector &solution, const GroupVector &right_hand_side) {
    Epetra_Vector z(View, solution.trilinos_vector(), 0);
    const Epetra_Vector r(View, right_hand_side.trilinos_vector(), 0);
    by_degree ? by_degree->vmult(z, r) : aggregation->vmult(z, r);
  };
  return solve_by_iteration(K, facts, cycle, x, b, goal, gives_up);
}

namespace {
[[maybe_unused]] const bool registered = SolverCatalogue::add<Multigrid>(
    "multigrid", "ML as preconditioner of CG, or of GMRES if the group is not symmetric or has multipliers.");
}

} // namespace dovetail
