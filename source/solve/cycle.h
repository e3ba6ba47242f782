// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The V-cycle of algebraic multigrid, however its levels are made.

#pragma once

#include "chebyshev_smoother.h"
#include "compact_matrix.h"
#include "factors.h"

#include <Epetra_CrsMatrix.h>
#include <Epetra_Import.h>
#include <Epetra_MultiVector.h>
#include <Epetra_Vector.h>

#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace dovetail {

/// About the inverse of a symmetric positive definite matrix, by a V-cycle with a ChebyshevSmoother on each
/// level and the factors of the coarsest matrix, or another cycle for it. Who derives from it adds the
/// levels. The levels hold their matrices in single precision once the coarser matrix has been summed of
/// them.
class Cycle
{
public:
  struct LevelFacts
  {
    double known_eigenvalue = 0; ///< the largest one of diag(A)^-1 A, from below; 0: not known
    double share_of_next = 1;    ///< unknowns of the next level, beside those of this one; for Semicoarsening
  };
  /// Makes the smoother of the matrix of a level, which is referred to.
  using MakeSmoother =
      std::function<std::unique_ptr<ChebyshevSmoother>(const LevelEntries &A, const LevelFacts &facts)>;

  /// The finest matrix: which somebody else holds, or which nobody else needs.
  class Finest
  {
  public:
    /// @param may_round products may be in single precision, as those of the other levels
    Finest(const Epetra_CrsMatrix &A, const bool may_round = false) // NOLINT: either is a matrix
        : A(&A), may_round(may_round)
    {
    }
    Finest(std::unique_ptr<Epetra_CrsMatrix> A) // NOLINT
        : owned(std::move(A)), A(owned.get()), may_round(true)
    {
    }

    const Epetra_CrsMatrix &matrix() const { return *A; }

  private:
    friend class Cycle;
    std::unique_ptr<Epetra_CrsMatrix> owned; ///< nullptr, or A
    const Epetra_CrsMatrix *A;
    bool may_round;
  };

  using MakeMatrix = std::function<std::unique_ptr<Epetra_CrsMatrix>()>;

  virtual ~Cycle() = default;
  void vmult(Epetra_MultiVector &x, const Epetra_MultiVector &b) const;
  /// Whether this cycle, or the one for its coarsest matrix, coarsens along short couplings.
  virtual bool is_semicoarsening() const { return below && below->is_semicoarsening(); }
  /// Whether there are more than the factors of the matrix.
  bool has_levels() const { return !levels.empty() || (below && below->has_levels()); }

protected:
  static constexpr int largest_coarse = 2000;   ///< rows of a matrix that is not coarsened
  static constexpr double largest_growth = 0.9; ///< rows of a level beside those of the finer one
  static constexpr int few_rows = 1000;         ///< of a rank; with less on average, ranks are gathered

  explicit Cycle(Finest finest) : last(std::move(finest)) {}

  /// Of the last level so far.
  const Epetra_CrsMatrix &coarsest() const { return *last.A; }
  unsigned int n_levels() const { return levels.size(); }

  /// Below the last one: with @p P from its unknowns, and its matrix P^T A P, which @p make_coarse gives when
  /// A and P are not there any more.
  void add_level(const MakeSmoother &make_smoother, std::unique_ptr<Epetra_CrsMatrix> P,
                 const MakeMatrix &make_coarse, const LevelFacts &facts);
  /// Gives the rows of ranks that follow each other to the first one of them where the ranks with rows have
  /// few each: aggregates do not cross ranks, so that many ranks could not coarsen any further.
  /// @return how to bring what belongs to the rows there; nullptr if they stay where they are. Collective.
  const Epetra_Import *gather_coarsest();
  /// @param first_row of each node, as Factors takes them
  void factorise_coarsest(const std::vector<int> &first_row = {})
  {
    factors = std::make_unique<Factors>(coarsest(), first_row);
  }
  /// In place of its factors. The matrix belongs to the cycle that @p make makes.
  void solve_coarsest_by(const std::function<std::unique_ptr<Cycle>(Finest A)> &make)
  {
    below = make(std::move(last));
  }

private:
  struct Level
  {
    std::unique_ptr<LevelEntries> A;
    std::unique_ptr<CompactMatrix> P; ///< from the next level
    std::unique_ptr<ChebyshevSmoother> smoother;
    std::unique_ptr<Epetra_Import> gather; ///< of the rows of the next level; nullptr: they stay
  };

  void cycle(unsigned int level, Epetra_Vector &x, const Epetra_Vector &b) const;
  void correct(const Level &level, unsigned int next, Epetra_Vector &x, const Epetra_Vector &b) const;

  std::vector<Level> levels; ///< all but the coarsest
  Finest last;               ///< the coarsest one
  std::unique_ptr<Factors> factors;
  std::unique_ptr<Cycle> below; ///< instead
};

/// The factors of a matrix, without levels.
class FactorisedCycle : public Cycle
{
public:
  FactorisedCycle(Finest A, const std::vector<int> &first_row) : Cycle(std::move(A))
  {
    factorise_coarsest(first_row);
  }
};

/// What belongs to rows, where @p import brings them. Collective.
std::unique_ptr<Epetra_MultiVector> imported(const Epetra_MultiVector &of_rows, const Epetra_Import &import);

} // namespace dovetail
