// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// MUMPS: L D L^T where the matrix is symmetric and has no multipliers, else L U.
//
//     subsection Linear solver
//       set Type = direct
//     end
//
// P. R. Amestoy, I. S. Duff, J.-Y. L'Excellent, J. Koster: A fully asynchronous multifrontal solver using
// distributed dynamic scheduling, 2001.

#include "factors.h"
#include "mumps_factors.h"
#include "nested_dissection.h"

#include <dovetail/scene/section.h>
#include <dovetail/solve/free_memory.h>
#include <dovetail/solve/group_solver.h>

#include <deal.II/base/mpi.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_Vector.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace dovetail {

class Direct : public GroupSolver
{
public:
  Direct(const Section &section, const GroupFacts &facts)
      : facts(facts), largest_memory(section.read<double>(
                          "Memory of factors", 0,
                          "What the factors of direct may take on one machine, 0: what is free there [MiB]",
                          Patterns::Double(0)))
  {
  }

  std::string description() const override { return "MUMPS"; }
  std::optional<ExpectedCost> expected_cost(const GroupSize &size) const override;
  void prepare(const GroupOperator &K, const Agreement &ranks) override;
  unsigned int solve(const GroupOperator &, GroupVector &x, const GroupVector &b, double) override;
  std::string shortage() const override { return missing; }
  std::optional<unsigned long> n_negative_eigenvalues() const override
  {
    return factors && factors->are_symmetric() ? factors->n_negative_pivots()
                                               : std::optional<unsigned long>();
  }
  void forget() override { factors.reset(); }

private:
  void check_memory(const MPI_Comm &communicator);
  bool is_negative_by_determinant(const Epetra_CrsMatrix &A, const MPI_Comm &communicator) const;

  const GroupFacts &facts;
  const double largest_memory; ///< MiB
  std::unique_ptr<MumpsFactors> factors;
  std::string missing;
};

/// In 3D n^(4/3) entries of the factors of a cube, m n with fewer nodes m across (work_of_factors).
std::optional<ExpectedCost> Direct::expected_cost(const GroupSize &size) const
{
  const double share = facts.is_positive_definite() ? 1 : 2; // L U
  const double n = size.n_unknowns, across = facts.shape.nodes_across,
               thin = thin_share(n, facts.dim, across), operations = work_of_factors(n, facts.dim, across),
               n_factors = facts.dim == 3 ? 30 * thin * std::pow(n, 4. / 3) : 10 * n * std::log2(n + 1);
  return {{390 * size.n_entries + share * operations, 4 * share * n_factors, 8 * share * n_factors}};
}

void Direct::prepare(const GroupOperator &K, const Agreement &ranks)
{
  const Epetra_CrsMatrix &A = *K.matrix();
  bool is_same = false;
  missing.clear();
  ++preparations.made;
  if (!factors || !factors->suit(A.NumGlobalRows(), facts.is_positive_definite()))
    ranks.run("factorisation", [&]() {
      factors = std::make_unique<MumpsFactors>(ranks.communicator, A.NumGlobalRows(),
                                               facts.is_positive_definite(), facts.has_multipliers);
    });
  ranks.run("entries", [&]() { is_same = factors->take(A); });
  if (dealii::Utilities::MPI::min(static_cast<int>(is_same), ranks.communicator) == 0) {
    std::vector<int> nodes; // of vectors in 3D: of others, MUMPS' order is as good
    ranks.run("nodes", [&]() {
      if (facts.dim == 3 && facts.n_components > 1)
        nodes = rows_of_nodes(A);
    });
    ranks.run("analysis", [&]() { factors->analyse(nodes); });
    check_memory(ranks.communicator);
  }
  ranks.run("factors", [&]() { factors->factorise(); });
  met_negative = !factors->are_symmetric() && is_negative_by_determinant(A, ranks.communicator);
}

/// An odd number of real eigenvalues below zero turns the sign of det K. Each multiplier that acts does so,
/// too: its diagonal entry is not positive.
bool Direct::is_negative_by_determinant(const Epetra_CrsMatrix &A, const MPI_Comm &communicator) const
{
  unsigned long n_multipliers = 0;
  if (facts.has_multipliers) {
    Epetra_Vector diagonal(A.RowMap());
    A.ExtractDiagonalCopy(diagonal);
    for (int i = facts.n_own_of_bodies; i < diagonal.MyLength(); ++i)
      n_multipliers += !(diagonal[i] > 0);
    n_multipliers = dealii::Utilities::MPI::sum(n_multipliers, communicator);
  }
  return factors->has_negative_determinant() != (n_multipliers % 2 == 1);
}

/// The kernel would end the process without a word.
void Direct::check_memory(const MPI_Comm &communicator)
{
  const double needed = factors->memory_on_machine(),
               there = largest_memory > 0 ? largest_memory : free_memory();
  if (dealii::Utilities::MPI::max(needed - there, communicator) <= 0)
    return;
  const auto rounded = [&communicator](const double number) {
    std::ostringstream text;
    text << std::setprecision(3) << dealii::Utilities::MPI::max(number, communicator);
    return text.str();
  };
  missing = "its factors need about " + rounded(needed) + " MiB on one machine, and " + rounded(there) +
            " MiB are " + (largest_memory > 0 ? "allowed" : "free");
  factors.reset();
  throw std::runtime_error(missing);
}

unsigned int Direct::solve(const GroupOperator &, GroupVector &x, const GroupVector &b, const double)
{
  factors->solve(x.trilinos_vector()[0], b.trilinos_vector()[0]);
  return 1;
}

namespace {
[[maybe_unused]] const bool registered = SolverCatalogue::add<Direct>(
    "direct", "MUMPS, for every group; takes over from the other solvers where they fail.");
}

} // namespace dovetail
