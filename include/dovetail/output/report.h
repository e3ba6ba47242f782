// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// report.json: what a run leaves behind in numbers.

#pragma once

#include <dovetail/scene/user_error.h>

#include <deal.II/base/mpi.h>

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace dovetail {

/// The report of a run. All keys stand in their order from the beginning; the run fills in their values.
class Report
{
public:
  /// Knows "version", "dealii" and "ranks" itself. @p directory is made if it does not exist. Collective.
  Report(const std::string &directory, const MPI_Comm &communicator);

  /// The value of one of the keys: dofs, converged, errors against, domains, interfaces, balance, probes,
  /// steps, adaptive cycles, seconds, counters, notes, plan, left out.
  nlohmann::ordered_json &operator[](const std::string &key);

  /// A key that only some scenes have.
  void add(const std::string &key, const nlohmann::ordered_json &value) { content[key] = value; }
  /// One solve with Newton's method.
  void add_step(double time, const std::vector<double> &residuals,
                const std::vector<unsigned int> &linear_iterations);
  void leave_out(const std::string &sentence); ///< "what: why", what this run did not do

  /// Write `<Directory>/report.json`; numbers that are not finite become null. "peak memory MiB" is the sum
  /// over the ranks of the largest resident memory each had. Collective. @throw UserError or OutputError on
  /// all ranks if the file cannot be written; then an older one stays as it is.
  void write();
  const nlohmann::ordered_json &all() const { return content; }

  const std::string file_name;

private:
  MPI_Comm communicator;
  nlohmann::ordered_json content;
};

/// Make a directory on rank 0 and wait for it. Collective. @throw UserError or OutputError on all ranks if
/// that fails.
void make_directory(const std::string &directory, const MPI_Comm &communicator);

} // namespace dovetail
