// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/first_guess.h>
#include <dovetail/run/given_values.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <limits>
#include <sstream>

namespace dovetail {

namespace {

const NoteName of_first_guess("first guess",
                              "the Initial of a nonlinear scene is far from all that is given");

/// Of the Initial of a body at its cells. Collective.
template <int dim>
ValueRange range_of_guess(const Domain<dim> &body, const Expression &initial, const MPI_Comm &communicator)
{
  ValueRange range{{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()}};
  for (const auto &cell : body.mesh().active_cell_iterators())
    if (cell->is_locally_owned()) {
      const double value = initial.value(cell->center(), 0., 0);
      range = {{std::min(range[0], value), std::max(range[1], value)}};
    }
  return {{dealii::Utilities::MPI::min(range[0], communicator),
           dealii::Utilities::MPI::max(range[1], communicator)}};
}

/// Of what is given at the beginning and at the end, as far as loads grow. Nothing if it is in no range.
template <int dim>
std::optional<ValueRange> range_of_given(const GivenValues<dim> &given, const std::string &field,
                                         const Steps &steps)
{
  std::optional<ValueRange> range;
  for (const double t : {0., steps.size(), steps.end_time}) {
    const auto at_time = given.range(field, t);
    if (!at_time || !((*at_time)[0] <= (*at_time)[1]))
      return {};
    range = range ? ValueRange{{std::min((*range)[0], (*at_time)[0]), std::max((*range)[1], (*at_time)[1])}}
                  : *at_time;
  }
  return range;
}

template <int dim>
void add_note_on_guess(const Domain<dim> &body, const Field &field, const GivenValues<dim> &values,
                       const Steps &steps, const MPI_Comm &communicator, NoteList &notes)
{
  const auto range = range_of_given(values, field.name, steps);
  if (!range)
    return;
  const auto [low, high] = *range;
  const ValueRange guess = range_of_guess(body, *body.initial().find(field.name), communicator);
  const double distance = std::max(low - guess[1], guess[0] - high),
               usual = 2 * (high - low) + 0.1 * std::max(std::abs(low), std::abs(high));
  if (!(distance > usual))
    return;
  std::ostringstream words;
  words.precision(4);
  words << "the first guess of its " << field.name << ", Initial, is " << guess[0];
  if (guess[1] > guess[0])
    words << " to " << guess[1];
  words << ", far from what is given, " << low;
  if (high > low)
    words << " to " << high;
  words << ": Newton's method has a long way, on which laws may be asked where they do not hold. Remove the "
           "entry (the guess is then the mean of what is given), or give a nearer one";
  notes.push_back(of_first_guess(words.str()).of(body.name));
}

} // namespace

template <int dim>
NoteList notes_on_first_guess(const Model<dim> &model, const Steps &steps)
{
  NoteList notes;
  if (steps.kind == Steps::Kind::transient || model.is_linear())
    return notes;
  std::optional<GivenValues<dim>> values;
  for (const auto &group : model.field_groups())
    if (!model.is_linear(group))
      for (const auto &body : model.domains)
        for (const Field &field : body->fields())
          if (field.n_components == 1 && body->initial().find(field.name) != nullptr &&
              std::find(group.begin(), group.end(), field.name) != group.end()) {
            if (!values)
              values.emplace(model);
            add_note_on_guess(*body, field, *values, steps, model.communicator, notes);
          }
  return notes;
}

template NoteList notes_on_first_guess(const Model<2> &, const Steps &);
template NoteList notes_on_first_guess(const Model<3> &, const Steps &);

} // namespace dovetail
