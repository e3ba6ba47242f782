// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Wall-clock seconds by phase.

#pragma once

#include <deal.II/base/mpi.h>
#include <deal.II/base/timer.h>

#include <nlohmann/json.hpp>

#include <map>
#include <string>

namespace dovetail {

/// Sums of wall-clock seconds by phase of this rank; the report shows the largest over the ranks.
class Phases
{
public:
  /// Adds the time of its life to a phase.
  class Scope
  {
  public:
    Scope(Phases &phases, const std::string &name) : seconds(phases.seconds[name]) {}
    ~Scope() { seconds += timer.wall_time(); }
    Scope(const Scope &) = delete;
    Scope &operator=(const Scope &) = delete;

  private:
    double &seconds;
    dealii::Timer timer;
  };

  void add(const std::string &name, const double value) { seconds[name] += value; }

  /// All phases of the report in its order, and "total" since this object was made. Collective.
  nlohmann::ordered_json largest_of_ranks(const MPI_Comm &communicator) const
  {
    nlohmann::ordered_json result;
    for (const std::string name : {"mesh", "pairing", "setup", "assembly", "solve", "output", "tie"}) {
      const auto found = seconds.find(name);
      result[name] = dealii::Utilities::MPI::max(found == seconds.end() ? 0. : found->second, communicator);
    }
    if (const auto found = seconds.find("comparison"); found != seconds.end()) // on all ranks or none
      result["comparison"] = dealii::Utilities::MPI::max(found->second, communicator);
    result["total"] = dealii::Utilities::MPI::max(total.wall_time(), communicator);
    return result;
  }

private:
  std::map<std::string, double> seconds;
  dealii::Timer total;
};

} // namespace dovetail
