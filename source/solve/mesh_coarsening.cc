// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "mesh_coarsening.h"

#include "aggregate_products.h"
#include "followed_sums.h"

#include <dovetail/solve/prolongation.h>

#include <Epetra_Comm.h>
#include <Epetra_IntVector.h>

#include <algorithm>
#include <iterator>
#include <utility>

namespace dovetail {

namespace {

/// Of all rows after so many steps.
RowSums sums_after(const unsigned int n_steps, const MeshLevels &levels, const RowSums &sums,
                   const Epetra_Map &rows)
{
  RowSums result;
  GroupFacts::Sum sum;
  for (unsigned int row = 0; row < sums.size(); ++row) {
    const bool is_gone =
        levels.step[row] > 0 && levels.step[row] <= n_steps && sums.is_only(row, rows.GID(row));
    const RowSums::Row given = is_gone ? levels.means[row] : sums[row];
    sum.clear();
    for (unsigned int k = 0; k < given.n; ++k)
      sum.emplace_back(given.columns[k], given.weights[k]);
    result.add_row(sum);
  }
  return result;
}

/// Between own rows that are unknowns of the finer and of the coarser level.
MeshStep make_mesh_step(RowSums &&sums, const RowSums &first_sums, const Epetra_Map &rows,
                        const Selection &finer, const Selection &coarser)
{
  MeshStep result;
  for (unsigned int i = 0, next = 0; i < finer.size() && next < coarser.size(); ++i)
    if (finer[i] == coarser[next]) {
      result.rows.push_back(i);
      ++next;
    }
  const Epetra_Map range(-1, static_cast<int>(finer.size()), 0, rows.Comm()),
      domain(-1, static_cast<int>(coarser.size()), 0, rows.Comm());
  Epetra_IntVector number(rows);
  number.PutValue(-1);
  for (unsigned int i = 0; i < coarser.size(); ++i)
    number[coarser[i]] = domain.GID(i);
  FollowedSums followed(std::move(sums), rows, number);
  result.P =
      Prolongation(range, domain, [&](const int i, std::vector<int> &columns, std::vector<double> &weights) {
        columns.clear();
        weights.clear();
        if (const int row = finer[i]; first_sums.is_only(row, rows.GID(row)))
          followed.read(row, columns, weights); // others are alone in their equations
      }).matrix();
  result.has_circles = followed.has_circles();
  return result;
}

int most_of_ranks(const Epetra_Comm &communicator, int here)
{
  int result = 0;
  communicator.MaxAll(&here, &result, 1);
  return result;
}

int sum_of_ranks(const Epetra_Comm &communicator, int here)
{
  int result = 0;
  communicator.SumAll(&here, &result, 1);
  return result;
}

} // namespace

std::vector<MeshStep> make_mesh_steps(const MeshLevels &levels, const RowSums &sums, const Epetra_Map &rows,
                                      Selection finest, const bool needs_parts)
{
  const int few = 2000;
  const double largest_share = 0.5; // of the unknowns of the finer mesh
  const Epetra_Comm &ranks = rows.Comm();
  const int last = most_of_ranks(
      ranks, levels.step.empty() ? 0 : *std::max_element(levels.step.begin(), levels.step.end()));
  std::vector<MeshStep> result;
  for (int step = 1; step <= last; ++step) {
    Selection coarser;
    std::copy_if(finest.begin(), finest.end(), std::back_inserter(coarser), [&](const int row) {
      return sums.is_only(row, rows.GID(row)) && (levels.step[row] == 0 || levels.step[row] > step);
    });
    const int n_fine = sum_of_ranks(ranks, finest.size()), n_coarse = sum_of_ranks(ranks, coarser.size());
    const bool has_parts = step == 1 && levels.has_parts, is_needed = has_parts && needs_parts;
    if (n_fine <= few || n_coarse == 0 || (!is_needed && n_coarse > largest_share * n_fine))
      break;
    result.push_back(make_mesh_step(sums_after(step, levels, sums, rows), sums, rows, finest, coarser));
    result.back().may_be_stretched = has_parts;
    if (most_of_ranks(ranks, result.back().has_circles) != 0)
      return {};
    finest = std::move(coarser);
  }
  return result;
}

std::unique_ptr<Epetra_MultiVector> select_rows(const Epetra_MultiVector &modes, const Epetra_Map &map,
                                                const Selection &rows)
{
  auto result = std::make_unique<Epetra_MultiVector>(map, modes.NumVectors());
  for (unsigned int i = 0; i < rows.size(); ++i)
    for (int mode = 0; mode < modes.NumVectors(); ++mode)
      (*result)[mode][i] = modes[mode][rows[i]];
  return result;
}

namespace {

/// The levels of coarser meshes, above those of another cycle.
class MeshCoarsening : public Cycle
{
public:
  explicit MeshCoarsening(Finest A) : Cycle(std::move(A)) {}

  /// An incomplete factorisation sees how the components at a node are coupled, and takes fewer iterations
  /// and less time than the diagonal. Where cells may be stretched, some more steps serve.
  void add(MeshStep step)
  {
    const MakeMatrix make_coarse = sum_coarse_matrix(coarsest(), *step.P, 1);
    const auto range =
        step.may_be_stretched ? ChebyshevSmoother::Range{3, 25} : ChebyshevSmoother::Range{2, 10};
    add_level([range](const LevelEntries &A,
                      const LevelFacts &) { return ChebyshevSmoother::with_factorisation(A, range); },
              std::move(step.P), make_coarse, {});
  }
  using Cycle::solve_coarsest_by;
};

} // namespace

std::unique_ptr<Cycle>
coarsen_mesh(Cycle::Finest A, std::vector<MeshStep> steps, std::shared_ptr<const Epetra_MultiVector> modes,
             std::vector<GroupFacts::Place> places,
             const std::function<std::unique_ptr<Cycle>(Cycle::Finest A,
                                                        std::shared_ptr<const Epetra_MultiVector> modes,
                                                        std::vector<GroupFacts::Place> places)> &make_coarse)
{
  if (steps.empty())
    return make_coarse(std::move(A), std::move(modes), std::move(places));
  auto result = std::make_unique<MeshCoarsening>(std::move(A));
  for (MeshStep &step : steps) {
    modes = select_rows(*modes, step.P->DomainMap(), step.rows);
    for (unsigned int i = 0; i < step.rows.size() && !places.empty(); ++i)
      places[i] = places[step.rows[i]]; // in ascending order
    places.resize(std::min(places.size(), step.rows.size()));
    result->add(std::move(step));
  }
  result->solve_coarsest_by([&](Cycle::Finest coarsest) {
    return make_coarse(std::move(coarsest), std::move(modes), std::move(places));
  });
  return result;
}

} // namespace dovetail
