// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What the conditions of a scene prescribe, at the nodes of their boundaries and over time.

#pragma once

#include <dovetail/system/model.h>

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dovetail {

/// The value at which a condition would leave a scalar field alone: the prescribed one, or the ambient one,
/// where the influx h(T) vanishes, T = -h(0)/h'(0).
template <int dim>
std::optional<double> given_value(const Domain<dim> &domain, const Condition<dim> &condition,
                                  const dealii::Point<dim> &X, double t);

/// Between which values a scalar field should stay. Without any the first number is the larger one.
using ValueRange = std::array<double, 2>;

/// The nodes of the conditions of all domains on the present meshes, collected once.
template <int dim>
class GivenValues
{
public:
  explicit GivenValues(const Model<dim> &model);

  /// The smallest and the largest of the values of a scalar field at time @p t over all bodies, between which
  /// a static solution lies; nothing with sources, given influxes and prescribed jumps, which may lead out of
  /// any range. Collective.
  std::optional<ValueRange> range(const std::string &field, double t) const;

  /// Whether a prescribed value, an influx or a given source (at the centres of cells) jumps between two
  /// times: however often the interval is halved, more than half of the change happens in one of the halves.
  /// Collective.
  bool jump_between(double begin, double end) const;

private:
  struct Place
  {
    const Domain<dim> *domain;
    const Condition<dim> *condition;
    dealii::Point<dim> X;
  };
  bool has_sources(const std::string &field) const;
  bool jump_at(const Place &place, double begin, double end) const;

  const Model<dim> &model;
  std::vector<Place> places;
  std::vector<std::pair<const Expression *, dealii::Point<dim>>> sources; ///< that depend on time
};

} // namespace dovetail
