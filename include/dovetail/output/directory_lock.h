// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// One run or study at a time in a directory.

#pragma once

#include <dovetail/output/new_file.h>

#include <deal.II/base/mpi.h>

#include <memory>
#include <string>

namespace dovetail {

/// While it lives, `dovetail.lock` in the directory names this process and its host. The operating system
/// holds the file locked for as long as the process lives, so that the file of one that has died is
/// recognised by every process of the same host: it is taken over, and what the dead one was writing is
/// cleared away. A file of another host cannot be judged and stays.
class DirectoryLock
{
public:
  /// Waits a second for a process that may be ending. @pre The directory exists.
  explicit DirectoryLock(const std::string &directory);
  ~DirectoryLock();
  DirectoryLock(const DirectoryLock &) = delete;
  DirectoryLock &operator=(const DirectoryLock &) = delete;

  const Obstacle &obstacle() const { return problem; } ///< why it is not locked, if it is not

private:
  bool take(); ///< @return whether it is decided
  void clear_after(const std::string &owner) const;
  void sign();

  const std::string directory, file;
  int descriptor = -1; ///< of the locked file
  bool is_held = false;
  Obstacle problem;
};

/// The first rank holds the lock, the others nothing. Collective. @throw UserError or OutputError on all
/// ranks.
std::unique_ptr<DirectoryLock> lock_directory(const std::string &directory, const MPI_Comm &communicator);

constexpr const char *wait_for_the_other_run =
    "Wait for the end of that run, or set another Directory in the subsection Output.";

} // namespace dovetail
