// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What solves the equations of one group of fields, K x = b: a plugin that sees an operator and facts.

#pragma once

#include <dovetail/scene/catalogue.h>
#include <dovetail/solve/mesh_levels.h>
#include <dovetail/solve/part_operator.h>
#include <dovetail/solve/row_sums.h>

#include <deal.II/base/mpi.h>
#include <deal.II/lac/trilinos_vector.h>

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

class Epetra_CrsMatrix;

namespace dovetail {

using GroupVector = dealii::TrilinosWrappers::MPI::Vector;
/// Numbers of some own rows or unknowns, ascending. A pointer to none stands for all.
using Selection = std::vector<unsigned int>;

/// K of a group. Each rank owns a contiguous range of rows: the unknowns of its bodies, body after body, then
/// its multipliers.
class GroupOperator
{
public:
  virtual ~GroupOperator() = default;

  virtual GroupVector vector() const = 0; ///< zero
  virtual void vmult(GroupVector &destination, const GroupVector &source) const = 0;
  virtual void diagonal(GroupVector &destination) const = 0;
  /// nullptr if there is none, but only vmult. Where multipliers were condensed, this matrix, or the sum of
  /// cells() and entries(), is only about K.
  virtual const Epetra_CrsMatrix *matrix() const { return nullptr; }
  /// K is the sum of entries() and of the products of cells(), which have no entries; nullptr: none.
  virtual const PartOperator *cells() const { return nullptr; }
  virtual const Epetra_CrsMatrix *entries() const { return matrix(); }
  /// K is the sum of matrix() and of R^T R with these rows R; nullptr: none.
  virtual const Epetra_CrsMatrix *added_rows() const { return nullptr; }

  /// A of [A B^T; B -C]: without the multipliers; or A + B^T W B. *this if there are none.
  virtual const GroupOperator &bodies() const { return *this; }
  /// By own multiplier: z is about S^-1 r, where S = C + B A^-1 B^T, or with A + B^T W B in place of A. If it
  /// was dropped, x = b is its equation, and S = -1. Collective.
  virtual void solve_schur_complement(double * /*z*/, const double * /*r*/) const {}
  /// The diagonal W by own multiplier; nullptr if W = 0 on all ranks. [A B^T; B -C] x = b is preconditioned
  /// as
  /// @f[ \begin{pmatrix} A + B^T W B & B^T (I - W C) \\ B & -C \end{pmatrix} x
  ///     = \begin{pmatrix} I & B^T W \\ 0 & I \end{pmatrix} b. @f]
  virtual const std::vector<double> *augmentation() const { return nullptr; }
};

/// How many nodes lie across bodies, and how far apart they are beside the thickness. About: of a plate 1/2
/// means square cells.
struct BodyShape
{
  double nodes_across = 0;          ///< 0: not known
  double distance_by_thickness = 0; ///< of nodes along a free boundary, on average
  double flat_share = 0; ///< of the unknowns, in bodies that are plates by themselves, with few nodes across
};

/// What describes a group of fields that is solved at once.
struct GroupTraits
{
  std::string name; ///< for messages: its fields
  unsigned int dim = 3;
  unsigned int degree = 1;       ///< the largest one of the bodies
  unsigned int n_components = 1; ///< of all fields
  unsigned long n_unknowns = 0;  ///< of all ranks
  unsigned int n_solves = 1;     ///< that a matrix is kept for: where it never changes
  bool is_symmetric = true;      ///< and, but for multipliers, positive definite; may change with K
  std::string why_entries;       ///< why the cells' part of K must have entries; empty if products do
  std::string why_matrix;        ///< why a matrix is faster, if products do; empty: it is not
  bool expects_contrast = false; ///< by the laws of bodies, in a linear stage; K need not be known
  BodyShape shape;               ///< of bodies in space that resist to be bent
  double n_followed = 0;         ///< unknowns that an unknown follows by constraints, on average
};

/// What is known of a group beside its operator. The functions may be called in GroupSolver::prepare.
struct GroupFacts : GroupTraits
{
  bool has_multipliers = false;
  unsigned int n_own_of_bodies = 0; ///< rows that this rank owns; those of multipliers follow
  bool is_positive_definite() const { return is_symmetric && !has_multipliers; }

  /// [mode][row of a selection of the own ones of GroupOperator::bodies()]: what the bodies hardly resist.
  /// Collective.
  std::function<std::vector<std::vector<double>>(const Selection *rows)> near_null_space;
  /// Of each own row of the bodies: the global rows, and the weights, that it is the sum of in a function of
  /// degree one; itself if it is an unknown of such a function; none if it is prescribed. May be missing.
  /// Collective.
  std::function<RowSums()> linear_part;
  /// Of the rows of the bodies; the cells of hexahedra that were divided, and @p with_parents those of cells
  /// that were refined. May be missing. Collective.
  std::function<MeshLevels(bool with_parents)> mesh_levels;
  using Sum = std::vector<std::pair<int, double>>; ///< one of them
  /// Of each own row of the bodies: the number of its field, from 0.
  std::function<std::vector<int>()> field_of_row;
  /// Of each own row of the bodies: the mean of the diagonal entries of its block. May be missing.
  /// Collective.
  std::function<std::vector<double>()> stiffness_of_row;
  unsigned int n_blocks = 1; ///< of the bodies
  /// The largest ratio of the stiffnesses of two blocks, of one field. May be missing.
  /// Collective.
  std::function<double()> contrast;
  static constexpr double small_contrast = 10;  ///< up to here an aggregate of two bodies serves both
  static constexpr double large_contrast = 1e3; ///< from here on bodies hardly share a mode
  bool has_large_contrast() const { return contrast && contrast() > large_contrast; } ///< collective
  /// Of some own rows of the bodies: the number of the block, and where the node is. May be missing.
  struct Place
  {
    unsigned int block = 0;
    std::array<double, 3> position{};
  };
  /// solve() may fail as soon as it expects more: another solver costs less then.
  double most_iterations = std::numeric_limits<double>::infinity();
  /// The same where a solver would go on by other means.
  double most_before_change = std::numeric_limits<double>::infinity();
  /// Asked by an iteration that has reached its goal with x: the goal to go on to, the same if it is done.
  /// Also asked when it begins.
  using NextGoal = std::function<double(const GroupVector &x, double goal, bool begins)>;
  NextGoal next_goal;
  std::function<std::vector<Place>(const Selection *rows)> places;
  std::vector<Place> known_places(const Selection *rows = nullptr) const
  {
    return places ? places(rows) : std::vector<Place>();
  }
};

/// How large a group is, for an estimate of what it costs.
struct GroupSize
{
  double n_unknowns = 0, n_entries = 0; ///< of K
  double n_modes = 1;                   ///< that its bodies hardly resist
};

/// What a solver takes, roughly, measured on blocks of cubes. The unit of work is what a product with K does
/// for one entry.
struct ExpectedCost
{
  double prepare = 0, solve = 0; ///< for one matrix, and for one right-hand side
  double bytes = 0;              ///< beside K
};

/// Lets all ranks go the same way where an exception (of a library, no memory) may meet one of them alone.
/// Where that happens in the middle of what the others do together nobody can help; so what takes memory is
/// an action of its own, before the others are entered.
struct Agreement
{
  MPI_Comm communicator = MPI_COMM_SELF;
  std::function<void(const std::string &place)> fault; ///< for tests: called before each action; may throw

  /// Whether @p action ends without an exception on all ranks. Collective.
  bool succeeds(const std::string &place, const std::function<void()> &action) const;
  /// @throw std::runtime_error on all ranks unless it does.
  void run(const std::string &place, const std::function<void()> &action) const;
};

/// Solves the systems of one group, for one matrix after the other. A failure is an exception: LinearSolver
/// then takes the direct solver, as it does if the true residual is not what was asked for. So a solver may
/// fail, but not do harm.
class GroupSolver
{
public:
  virtual ~GroupSolver() = default;

  /// For the plan: "CG with multigrid".
  virtual std::string description() const = 0;
  /// Why this group cannot be solved by it, "the matrix is not symmetric"; empty if it can.
  virtual std::string objection() const { return ""; }
  /// Whether it asks for all entries of K, before there is one. If not, those of cells are not made:
  /// GroupOperator::cells().
  virtual bool needs_entries() const { return true; }
  /// Whether it can solve with a K that has products of cells; or else with one that has all entries.
  virtual bool serves(const bool has_products) const { return needs_entries() != has_products; }

  /// Nothing if nobody has measured it.
  virtual std::optional<ExpectedCost> expected_cost(const GroupSize & /*size*/) const { return {}; }

  /// K has new values. What was made for the last ones may be kept, and counted as such. @p ranks: for steps
  /// that one rank alone may not survive.
  virtual void prepare(const GroupOperator &K, const Agreement &ranks) = 0;
  /// Until |b - K x| <= @p goal, from x = 0. @return the number of iterations. @pre prepare(K)
  virtual unsigned int solve(const GroupOperator &K, GroupVector &x, const GroupVector &b, double goal) = 0;
  /// Why the last prepare() failed, "its factors need about 9 MiB, and 8 MiB are free", if K was too large
  /// for this solver; else empty. The same on all ranks.
  virtual std::string shortage() const { return ""; }
  /// How many iterations the last solve() expected, if it has failed for that reason; else 0.
  double expected_iterations() const { return expected; }
  /// How many eigenvalues of the K that was prepared are negative, if that is a by-product. The same on all
  /// ranks.
  virtual std::optional<unsigned long> n_negative_eigenvalues() const { return {}; }
  /// Whether some are, as far as is known: of the last K that was solved with.
  bool has_met_negative() const { return n_negative_eigenvalues().value_or(met_negative) > 0; }
  /// K and what belongs to its structure will not be there any more.
  virtual void forget() {}

  /// Of prepare(), and of what was made anew in solve().
  struct Preparations
  {
    unsigned long made = 0, kept = 0;
  };
  const Preparations &counts() const { return preparations; }

protected:
  Preparations preparations;
  double expected = 0;       ///< iterations, of which there are too many
  bool met_negative = false; ///< an eigenvalue, if their number is not known
};

/// Adding one is adding a file: doc/how_to/add_a_solver.md.
using SolverCatalogue = Catalogue<GroupSolver, const GroupFacts &>;

} // namespace dovetail
