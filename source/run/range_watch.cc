// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/run/range_watch.h>

#include <dovetail/solve/convergence.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace dovetail {

namespace {

const NoteName of_range("range", "a result leaves the range that the given values allow");

const double allowed_share = 0.01;   ///< of the width of a range, beyond it, without a note
const double smallest_share = 1e-10; ///< that is no rounding

double rounding(const ValueRange &range)
{
  return Convergence::smallest_range * std::max(std::abs(range[0]), std::abs(range[1]));
}

void widen(ValueRange &range, const double smallest, const double largest)
{
  range[0] = std::min(range[0], smallest);
  range[1] = std::max(range[1], largest);
}

} // namespace

/// Blocks of unknowns of scalar fields.
template <int dim>
template <typename Visit>
void RangeWatch<dim>::for_each_scalar(const Visit &visit) const
{
  const auto &blocks = model.numbering->blocks();
  for (unsigned int b = 0; b < blocks.size(); ++b)
    if (!blocks[b].is_of_multipliers &&
        model.domains[blocks[b].domain_index]->fields()[blocks[b].field_index].n_components == 1)
      visit(b, blocks[b]);
}

template <int dim>
void RangeWatch<dim>::start(const Vector &x)
{
  histories.clear();
  for_each_scalar([&](const unsigned int b, const Block &block) {
    const ValueRange block_range = {{x.block(b).min(), x.block(b).max()}};
    const auto [entry, is_new] = histories.try_emplace(block.field, History{block_range, false, {}});
    if (!is_new)
      widen(entry->second.range, block_range[0], block_range[1]);
  });
}

template <int dim>
nlohmann::ordered_json RangeWatch<dim>::save() const
{
  nlohmann::ordered_json saved = nlohmann::ordered_json::object();
  for (const auto &[field, history] : histories) {
    const Worst &worst = history.worst;
    saved[field] = {{"range", history.range},
                    {"is open", history.is_open},
                    {"worst", {worst.share, worst.t, worst.size, worst.smallest, worst.largest}},
                    {"allowed then", worst.allowed},
                    {"block", worst.block}};
  }
  return saved;
}

template <int dim>
void RangeWatch<dim>::restore(const nlohmann::ordered_json &saved)
{
  histories.clear();
  for (const auto &[field, value] : saved.items()) {
    const std::vector<double> worst = value["worst"];
    histories[field] = {
        value["range"],
        value["is open"],
        {worst[0], worst[1], worst[2], worst[3], worst[4], value["allowed then"], value["block"]}};
  }
}

/// The history of a field with what is given at time @p t.
template <int dim>
typename RangeWatch<dim>::History RangeWatch<dim>::at(const std::string &field, const double t) const
{
  History history = histories.at(field);
  if (history.is_open)
    return history;
  const auto step_range = given.range(field, t);
  history.is_open = !step_range;
  if (step_range && (*step_range)[0] <= (*step_range)[1])
    widen(history.range, (*step_range)[0], (*step_range)[1]);
  return history;
}

template <int dim>
bool RangeWatch<dim>::leaves(const double t, const Vector &x) const
{
  bool is_any = false;
  for_each_scalar([&](const unsigned int b, const Block &block) {
    const History history = at(block.field, t);
    const double beyond = std::max(history.range[0] - x.block(b).min(), x.block(b).max() - history.range[1]);
    is_any = is_any || (!history.is_open && beyond > smallest_share * (history.range[1] - history.range[0]) +
                                                         1e-12 * std::max(std::abs(history.range[0]),
                                                                          std::abs(history.range[1])));
  });
  return is_any;
}

template <int dim>
void RangeWatch<dim>::add(const double t, const double size, const Vector &x)
{
  for (auto &[field, history] : histories)
    history = at(field, t);
  for_each_scalar([&](const unsigned int b, const Block &block) {
    History &history = histories.at(block.field);
    if (history.is_open)
      return;
    const double smallest = x.block(b).min(), largest = x.block(b).max(),
                 width = history.range[1] - history.range[0],
                 beyond = std::max(history.range[0] - smallest, largest - history.range[1]);
    if (beyond > allowed_share * width + rounding(history.range) &&
        beyond > history.worst.share * std::max(width, rounding(history.range)))
      history.worst = {
          beyond / std::max(width, rounding(history.range)), t, size, smallest, largest, history.range, b};
  });
}

template <int dim>
std::string RangeWatch<dim>::in_words(const Worst &worst) const
{
  const Block &block = model.numbering->blocks()[worst.block];
  double diameter = 0;
  for (const auto &cell : model.domains[block.domain_index]->mesh().active_cell_iterators())
    if (cell->is_locally_owned())
      diameter = std::max(diameter, cell->diameter());
  diameter = dealii::Utilities::MPI::max(diameter, model.communicator);
  std::ostringstream words;
  const double level = std::max(std::abs(worst.smallest), std::abs(worst.largest));
  words.precision(4 + static_cast<int>(std::log10(level / (worst.largest - worst.smallest))));
  words << "the " << block.field << " of " << block.name << " runs from " << worst.smallest << " to "
        << worst.largest << " at t = " << worst.t << ", but what has been given so far allows only "
        << worst.allowed[0] << " to " << worst.allowed[1];
  words.precision(4);
  words << ". A step of " << worst.size << " may be too short for cells of " << diameter
        << ", whose shape functions cannot follow a steep front: refine the mesh, take longer steps, or set "
           "Lumped capacity = true in the subsection Steps (with Degree = 1)";
  return words.str();
}

template <int dim>
NoteList RangeWatch<dim>::explain_history() const
{
  NoteList notes;
  for (const auto &[field, history] : histories)
    if (history.worst.share > 0)
      notes.push_back(of_range(in_words(history.worst)));
  return notes;
}

template <int dim>
NoteList RangeWatch<dim>::explain(const double t, const Vector &x) const
{
  NoteList notes;
  std::map<std::string, std::optional<ValueRange>> range_of_field;
  for_each_scalar([&](const unsigned int b, const Block &block) {
    const auto [entry, is_new] = range_of_field.try_emplace(block.field);
    if (is_new)
      entry->second = given.range(block.field, t);
    const auto &range = entry->second;
    if (!range || (*range)[0] > (*range)[1])
      return;
    const double smallest = x.block(b).min(), largest = x.block(b).max(),
                 allowed = (*range)[1] - (*range)[0] + rounding(*range);
    if (smallest >= (*range)[0] - allowed && largest <= (*range)[1] + allowed)
      return;
    std::ostringstream words;
    words.precision(4);
    words << "the " << block.field << " of " << block.name << " runs from " << smallest << " to " << largest
          << ", but what is prescribed allows only " << (*range)[0] << " to " << (*range)[1]
          << ": the result is not to be trusted. Refine the mesh where the field is steep";
    notes.push_back(of_range(words.str()));
  });
  return notes;
}

template class RangeWatch<2>;
template class RangeWatch<3>;

} // namespace dovetail
