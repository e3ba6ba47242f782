// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Files that all ranks write together, and agreement on what stands in the way.

#pragma once

#include <dovetail/output/new_file.h>

#include <deal.II/base/mpi.h>

#include <memory>
#include <string>

namespace dovetail {

/// One file that all ranks write, each its parts after those of the ranks before. The first rank receives and
/// writes them piece by piece: no file system has to know of several writers, and whether it worked is known
/// in one place.
class SharedFile
{
public:
  SharedFile(const std::string &name, const std::string &beginning, const MPI_Comm &communicator);
  /// Collective: the parts in the order of the ranks.
  void append(const char *bytes, std::size_t n_bytes);
  void append(const std::string &bytes) { append(bytes.data(), bytes.size()); }
  Obstacle finish(OnDisk on_disk = OnDisk::at_once); ///< Collective, and the same on all ranks.

private:
  void receive(int rank);
  void send(const char *bytes, std::size_t n_bytes) const;

  const MPI_Comm communicator;
  int rank, n_ranks;
  std::unique_ptr<NewFile> file; ///< of the first rank
};

/// What the first rank has found, on all ranks. Collective.
Obstacle agree(const Obstacle &found, const MPI_Comm &communicator);

/// What any rank has found, the same on all; empty if all are. Collective.
std::string first_problem(const std::string &own, const MPI_Comm &communicator);

/// As write_file(), by the first rank. Collective, and the same result on all ranks.
Obstacle write_on_first_rank(const std::string &name, const std::string &beginning, const std::string &text,
                             const MPI_Comm &communicator, OnDisk on_disk = OnDisk::at_once);

/// As bring_to_disk(), by the first rank, which writes all files. Collective, likewise.
Obstacle bring_to_disk(const MPI_Comm &communicator);

} // namespace dovetail
