// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A file of records that all ranks write and that any number of ranks read.

#pragma once

#include <dovetail/output/new_file.h>

#include <deal.II/base/mpi.h>

#include <nlohmann/json.hpp>

#include <cstdint>
#include <fstream>
#include <functional>
#include <map>
#include <string>

namespace dovetail {

/// The first line of the file: what it is, its format, and the size and the checksum of the header, which is
/// JSON. Then the records, one after the other, each with the parts of the ranks that wrote it; the header
/// knows their sizes and checksums (doc/theory/checkpoint.md).
struct RecordFile
{
  /// By name: what this rank has of each record.
  using Records = std::map<std::string, std::string>;

  static constexpr const char *first_words = "Dovetail checkpoint";
  static constexpr unsigned int format = 2;

  /// Whole or not at all (NewFile). Collective; all ranks have the same header and the same names.
  static Obstacle write(const std::string &name, nlohmann::ordered_json header, const Records &records,
                        const MPI_Comm &communicator);
};

/// Reads such a file: the first rank reads, the others receive. All functions are collective.
class RecordReader
{
public:
  /// @throw UserError on all ranks if there is no such file, or if it is damaged or of another format.
  RecordReader(const std::string &name, const MPI_Comm &communicator);

  const nlohmann::ordered_json &header() const { return content; }
  /// Calls @p visit on all ranks with the parts of a record, one after the other.
  void for_each_part(const std::string &record,
                     const std::function<void(const std::string &part)> &visit) const;

private:
  std::string read_here(std::uint64_t begin, std::uint64_t n_bytes) const;
  void check_records() const;
  void check_first_line(const std::string &line) const;
  [[noreturn]] void refuse(const std::string &why) const;

  const std::string name;
  const MPI_Comm communicator;
  mutable std::ifstream file; ///< of the first rank
  std::uint64_t begin_of_records = 0;
  nlohmann::ordered_json content;
};

} // namespace dovetail
