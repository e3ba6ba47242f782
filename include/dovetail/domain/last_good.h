// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The last good state at the boundary cells of a domain, for conditions whose toggles look at fields.

#pragma once

#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace dovetail {

/// The unknowns of some cells, by active cell index, at the beginning of the present step, and at that of the
/// step before. A step that ends at the time of the last good one is that step again, and sees what it saw.
class LastGood
{
public:
  using Unknowns = std::map<unsigned int, std::vector<double>>;

  /// Whether a step to time @p t needs the state at hand; else its state is known.
  bool begin_step(const double t)
  {
    if (before && before->first == t) {
      now = std::exchange(before, {});
      return false;
    }
    if (now && now->first == t)
      return false;
    if (now && t > now->first) // a step that fails is followed by one that ends earlier
      before = std::move(now);
    now.emplace(t, Unknowns());
    return true;
  }
  Unknowns &unknowns() { return now->second; } ///< to be filled
  /// Of a cell; empty where no step has begun.
  const std::vector<double> &of_cell(const unsigned int cell) const
  {
    static const std::vector<double> none;
    if (!now)
      return none;
    const auto found = now->second.find(cell);
    return found != now->second.end() ? found->second : none;
  }

private:
  std::optional<std::pair<double, Unknowns>> now, before; ///< with the time at which the step ends
};

} // namespace dovetail
