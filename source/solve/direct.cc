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

#include <dovetail/scene/section.h>
#include <dovetail/solve/free_memory.h>
#include <dovetail/solve/group_solver.h>

#include <deal.II/base/mpi.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_MpiComm.h>
#include <dmumps_c.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <memory>
#include <sstream>
#include <stdexcept>

namespace dovetail {

namespace {

/// The factors of one matrix after the other of the same structure. Functions are collective.
class MumpsFactors
{
public:
  MumpsFactors(const MPI_Comm &communicator, bool is_symmetric, bool has_small_pivots);
  ~MumpsFactors() { call(-2); }
  MumpsFactors(const MumpsFactors &) = delete;
  MumpsFactors &operator=(const MumpsFactors &) = delete;

  /// Take the entries of the own rows. @return whether their pattern is that of the last analysis; not
  /// collective
  bool take(const Epetra_CrsMatrix &A);
  void analyse();
  bool are_symmetric() const { return is_symmetric; } ///< L D L^T
  /// What factorise() will need on this rank, in MiB, estimated from above. @pre analyse()
  double memory() const { return (mumps.info[14] + 1) * 1e6 / (1024 * 1024); }
  void factorise();
  void solve(double *x, const double *b);
  /// Of D, as many as eigenvalues of the matrix are negative (Sylvester). @pre are_symmetric()
  unsigned long n_negative_pivots() const { return mumps.infog[11]; }

private:
  void call(const int job)
  {
    mumps.job = job;
    dmumps_c(&mumps);
  }
  void check() const
  {
    if (mumps.infog[0] < 0)
      throw std::runtime_error("MUMPS gives error " + std::to_string(mumps.infog[0]));
  }

  MPI_Comm communicator;
  bool is_symmetric, is_first, is_analysed = false;
  DMUMPS_STRUC_C mumps = {};
  std::vector<int> rows, columns; ///< from 1, of the entries; of a symmetric matrix the upper triangle
  std::vector<double> entries;
  int n_own = 0; ///< rows
  std::vector<int> n_of_rank, first_of_rank;
};

/// ICNTL(@p k) and the like are numbered from 1.
int &control(DMUMPS_STRUC_C &mumps, const int k)
{
  return mumps.icntl[k - 1];
}

MumpsFactors::MumpsFactors(const MPI_Comm &communicator, const bool is_symmetric, const bool has_small_pivots)
    : communicator(communicator), is_symmetric(is_symmetric),
      is_first(dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
{
  const int symmetric = 2, with_this_rank = 1, silent = -1, distributed = 3;
  mumps.comm_fortran = MPI_Comm_c2f(communicator);
  mumps.sym = is_symmetric ? symmetric : 0;
  mumps.par = with_this_rank;
  call(-1);
  check();
  for (const int output : {1, 2, 3})
    control(mumps, output) = silent;
  control(mumps, 4) = 0;
  control(mumps, 18) = distributed;
  control(mumps, 14) =
      has_small_pivots ? 100 : 20; // more than estimated, in per cent, for pivots off the diagonal
}

bool MumpsFactors::take(const Epetra_CrsMatrix &A)
{
  std::vector<int> new_rows, new_columns;
  entries.clear();
  for (int row = 0; row < A.NumMyRows(); ++row) {
    int n = 0, *local = nullptr;
    double *values = nullptr;
    A.ExtractMyRowView(row, n, values, local);
    for (int k = 0; k < n; ++k)
      if (const int i = A.GRID(row), j = A.GCID(local[k]); j >= i || !is_symmetric) {
        new_rows.push_back(i + 1);
        new_columns.push_back(j + 1);
        entries.push_back(values[k]);
      }
  }
  const bool is_same = new_rows == rows && new_columns == columns;
  rows = std::move(new_rows);
  columns = std::move(new_columns);
  mumps.n = A.NumGlobalRows();
  mumps.nnz_loc = entries.size();
  mumps.irn_loc = rows.data();
  mumps.jcn_loc = columns.data();
  mumps.a_loc = entries.data();
  n_own = A.NumMyRows();
  return is_same && is_analysed;
}

void MumpsFactors::analyse()
{
  is_analysed = false;
  n_of_rank = dealii::Utilities::MPI::all_gather(communicator, n_own);
  first_of_rank.assign(1, 0);
  for (const int n : n_of_rank)
    first_of_rank.push_back(first_of_rank.back() + n);
  call(1);
  check();
  is_analysed = true;
}

void MumpsFactors::factorise()
{
  const int workspace_is_too_small = -9, integers_are_too_small = -8;
  for (unsigned int attempt = 0; attempt < 3; ++attempt) {
    call(2);
    const int error = mumps.infog[0];
    if (error != workspace_is_too_small && error != integers_are_too_small)
      break;
    control(mumps, 14) *= 10;
  }
  check();
}

void MumpsFactors::solve(double *x, const double *b)
{
  std::vector<double> all(is_first ? mumps.n : 0);
  MPI_Gatherv(b, n_own, MPI_DOUBLE, all.data(), n_of_rank.data(), first_of_rank.data(), MPI_DOUBLE, 0,
              communicator);
  mumps.rhs = all.data();
  call(3);
  check();
  MPI_Scatterv(all.data(), n_of_rank.data(), first_of_rank.data(), MPI_DOUBLE, x, n_own, MPI_DOUBLE, 0,
               communicator);
}

/// The sum over the ranks that share a machine with this one.
double sum_on_machine(const double value, const MPI_Comm &communicator)
{
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(communicator, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  const double sum = dealii::Utilities::MPI::sum(value, machine);
  MPI_Comm_free(&machine);
  return sum;
}

} // namespace

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

  const GroupFacts &facts;
  const double largest_memory; ///< MiB
  std::unique_ptr<MumpsFactors> factors;
  std::string missing;
};

/// With nested dissection (George 1973): in 3D n^2 operations and n^(4/3) entries of the factors of a cube.
/// Of a body with fewer nodes m across, (m n)^(3/2) and m n.
std::optional<ExpectedCost> Direct::expected_cost(const GroupSize &size) const
{
  const double share = facts.is_positive_definite() ? 1 : 2; // L U
  const double n = size.n_unknowns, across_cube = std::cbrt(n / 3) / 3,
               thin = facts.shape.nodes_across > 0 ? std::min(1., facts.shape.nodes_across / across_cube) : 1,
               n_factors = facts.dim == 3 ? 30 * thin * std::pow(n, 4. / 3) : 10 * n * std::log2(n + 1),
               operations = facts.dim == 3 ? 1.6 * std::pow(thin, 1.5) * n * n : 6000 * n;
  return {{390 * size.n_entries + share * operations, 4 * share * n_factors, 8 * share * n_factors}};
}

void Direct::prepare(const GroupOperator &K, const Agreement &ranks)
{
  const Epetra_CrsMatrix &A = *K.matrix();
  bool is_same = false;
  missing.clear();
  ++preparations.made;
  if (!factors || factors->are_symmetric() != facts.is_positive_definite())
    ranks.run("factorisation", [&]() {
      factors = std::make_unique<MumpsFactors>(ranks.communicator, facts.is_positive_definite(),
                                               facts.has_multipliers);
    });
  ranks.run("entries", [&]() { is_same = factors->take(A); });
  if (dealii::Utilities::MPI::min(static_cast<int>(is_same), ranks.communicator) == 0) {
    ranks.run("analysis", [&]() { factors->analyse(); });
    check_memory(ranks.communicator);
  }
  ranks.run("factors", [&]() { factors->factorise(); });
}

/// The kernel would end the process without a word.
void Direct::check_memory(const MPI_Comm &communicator)
{
  const double needed = sum_on_machine(factors->memory(), communicator),
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
