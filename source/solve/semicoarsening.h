// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Algebraic multigrid for cells that are longer in some directions than in others.

#pragma once

#include "cycle.h"

#include <dovetail/solve/group_solver.h>

#include <Epetra_Comm.h>
#include <Epetra_CrsMatrix.h>
#include <Epetra_MultiVector.h>

#include <array>
#include <memory>
#include <vector>

namespace dovetail {

/// The nodes of a level on this rank: rows that follow each other and are at the same place of the same body.
struct LevelNodes
{
  std::vector<int> first_row; ///< by node, and the number of rows at the end
  std::vector<unsigned int> body;
  std::vector<std::array<double, 3>> position;

  unsigned int size() const { return body.size(); }
};
LevelNodes nodes_of_rows(const std::vector<GroupFacts::Place> &places);
/// Bodies are numbered from 0. @param body of the rows or nodes of this rank. Collective.
int number_of_bodies(const std::vector<unsigned int> &body, const Epetra_Comm &ranks);

/// By node of this rank the nodes that a matrix couples with it: those of this rank by their number, and
/// after them those of other ranks. Ascending.
using NodeGraph = std::vector<std::vector<unsigned int>>;

/// The couplings of A, and those of them that are short: within a body, and at most twice as long as the
/// shortest coupling of one of their nodes within its body. The closest ones are at most 1.2 times as long.
/// Nodes of two sides of a tie are close to each other, but a tie of cells that are long across it is a weak
/// spring beside the stiffness along it.
struct Couplings
{
  Couplings(const Epetra_CrsMatrix &A, const LevelNodes &nodes); ///< collective

  NodeGraph all, near, closest;
  std::vector<unsigned int> node_of_column; ///< of A
  unsigned int n_nodes = 0;                 ///< of this rank, and those of other ranks
  std::vector<unsigned int> line_length; ///< by node of this rank: of how many its line is; 0 if it has none
  double share_of_far = 0;               ///< of the nodes of all ranks: with a long one within a body
  double share_in_lines = 0;             ///< of the nodes of all ranks that are coupled with others
  double rows_together = 0; ///< mean of all ranks: of a node and those that short couplings connect with it
  double rows_closest = 0;  ///< the same, by the closest ones
  double rows_of_line = 0, nodes_of_line = 0; ///< means of the nodes in lines

  bool are_in_lines() const; ///< most of the nodes
  /// Most nodes are in lines of two or three, as across bodies that are one cell thick: an aggregate along
  /// short couplings is a whole line.
  bool are_in_short_lines() const;
  /// Short couplings make aggregates of many nodes, beside so many modes of each of them; the closest ones
  /// make smaller ones.
  bool are_many(int n_modes) const;
};

/// A V-cycle for a symmetric positive definite matrix A by smoothed aggregation whose aggregates follow short
/// couplings only. The distances of nodes across stretched cells grow from level to level until they are as
/// long as those along them. What varies along long cells, and hardly in the other directions, has small
/// eigenvalues that no smoother reaches; it stays on the coarse level.
///
/// The prolongation is P = (I - w D^-1 A_near) T + F: T spans the near-null space B on each aggregate, A_near
/// is A without its far couplings, and F is the least matrix in the pattern of P with P B_c = B, where B_c is
/// the near-null space of the coarse level. Where short couplings lead in all directions, P = (I - w D^-1 A)
/// T sees the other sides of ties, too. From the first level with long cells on, aggregates follow the
/// closest couplings where short ones are many, and P has A_near.
///
/// P. Vanek, J. Mandel, M. Brezina: Algebraic multigrid by smoothed aggregation for second and fourth order
/// elliptic problems, 1996. J. Mandel, M. Brezina, P. Vanek: Energy optimization of algebraic multigrid
/// bases, 1999.
class Semicoarsening : public Cycle
{
public:
  /// Where short couplings connect lines, an aggregate may be a whole line: smoothers with factorisations
  /// solve along lines. Lines of two or three nodes are whole in any case.
  enum class Lines {
    in_parts,
    whole_if_cheap, ///< where the levels of their parts would have about as many unknowns
    whole ///< also of scalars, where a line has the mean of some leaders, which its parts do not find
  };
  /// As largest_coarse; their ends make surfaces, and the memory of this machine may allow less. Collective.
  static int largest_of_lines(const Epetra_Comm &ranks);

  /// @param modes near-null space of A
  Semicoarsening(Finest A, const Epetra_MultiVector &modes, LevelNodes nodes,
                 const MakeSmoother &make_smoother, Lines lines);
  bool is_semicoarsening() const override { return true; }

private:
  static constexpr int largest_of_vectors = 5000; ///< as largest_coarse, below the first level
};

/// Whether more than a quarter of the nodes are coupled in their body with another one that is 2.8 times as
/// far as the next one. By some of the nodes, and what is on their rank. Collective.
bool are_mostly_stretched(const Epetra_CrsMatrix &A, const LevelNodes &nodes);
/// Whether the places of all rows are known. Collective.
bool are_all_known(const std::vector<GroupFacts::Place> &places, const Epetra_CrsMatrix &A);

/// When to take Semicoarsening in place of SmoothedAggregation.
enum class Semicoarsen {
  if_cheap,     ///< if that reduces the number of unknowns by about two or more, or if there are few in lines
  if_stretched, ///< if more than a tenth of the nodes have long couplings in their body
  always        ///< no aggregate has nodes of two bodies
};

/// @param places of the rows of A; empty if they are not known: SmoothedAggregation
/// @param if_semicoarsened makes the smoothers of Semicoarsening
std::unique_ptr<Cycle> make_cycle(Cycle::Finest A, std::shared_ptr<const Epetra_MultiVector> modes,
                                  std::vector<GroupFacts::Place> places, Semicoarsen when,
                                  const Cycle::MakeSmoother &make_smoother,
                                  const Cycle::MakeSmoother &if_semicoarsened, Semicoarsening::Lines lines);
/// With smoothers made of incomplete factorisations.
/// @param is_finest no level above A makes an iteration dearer, so that one more costs less than many steps
std::unique_ptr<Cycle> make_cycle_with_factorisations(Cycle::Finest A,
                                                      std::shared_ptr<const Epetra_MultiVector> modes,
                                                      std::vector<GroupFacts::Place> places, Semicoarsen when,
                                                      bool is_finest, Semicoarsening::Lines lines);
/// The same for functions of degree one, with whole lines.
std::unique_ptr<Cycle> make_cycle_of_whole_lines(Cycle::Finest A_1,
                                                 std::shared_ptr<const Epetra_MultiVector> modes,
                                                 std::vector<GroupFacts::Place> places);
/// With smoothers made of the diagonal. No aggregate has nodes of two bodies.
std::unique_ptr<Cycle> make_cycle_within_bodies(Cycle::Finest A,
                                                std::shared_ptr<const Epetra_MultiVector> modes,
                                                std::vector<GroupFacts::Place> places);
/// Whether stiff and soft bodies are such that aggregates of both may serve neither: there are three or more,
/// of which some two have more than this contrast. Collective.
bool has_mixed_bodies(const GroupFacts &facts, double contrast);

} // namespace dovetail
