// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Wall-clock seconds and memory by phase.

#pragma once

#include <deal.II/base/mpi.h>
#include <deal.II/base/timer.h>

#include <nlohmann/json.hpp>

#include <map>
#include <string>

namespace dovetail {

double peak_memory_of_process(); ///< in MiB

/// Sums of wall-clock seconds by phase of this rank; the report shows the largest over the ranks. And the
/// memory that they took.
class Phases
{
public:
  /// Adds the time of its life to a phase.
  class Scope
  {
  public:
    Scope(Phases &phases, const std::string &name) : phases(phases), name(name) {}
    ~Scope()
    {
      phases.add(name, timer.wall_time());
      if (phases.peak_memory.count(name) == 0)
        phases.peak_memory[name] = peak_memory_of_process();
    }
    Scope(const Scope &) = delete;
    Scope &operator=(const Scope &) = delete;

  private:
    Phases &phases;
    const std::string name;
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
    for (const std::string name : {"estimate", "comparison"}) // on all ranks or none
      if (const auto found = seconds.find(name); found != seconds.end())
        result[name] = dealii::Utilities::MPI::max(found->second, communicator);
    result["total"] = dealii::Utilities::MPI::max(total.wall_time(), communicator);
    return result;
  }

  /// What the ranks had taken at most when each phase ended for the first time, in MiB: the difference
  /// from the phase before is what it adds. Without phases that did not occur on all ranks. Collective.
  nlohmann::ordered_json memory(const MPI_Comm &communicator) const
  {
    nlohmann::ordered_json result = nlohmann::ordered_json::object();
    for (const std::string name : {"mesh", "pairing", "setup", "assembly", "solve", "output"}) {
      const auto found = peak_memory.find(name);
      const bool is_here = found != peak_memory.end();
      const double sum = dealii::Utilities::MPI::sum(is_here ? found->second : 0., communicator);
      if (dealii::Utilities::MPI::min(static_cast<int>(is_here), communicator) == 1)
        result[name] = sum;
    }
    return result;
  }

private:
  std::map<std::string, double> seconds, peak_memory;
  dealii::Timer total;
};

} // namespace dovetail
