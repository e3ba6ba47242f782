// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Files that one process writes: whole or not at all, and in the place of nothing but older ones of the same
// kind.

#pragma once

#include <stdexcept>
#include <string>

namespace dovetail {

/// What should be kept cannot be written, although the input is right: the disk is full. Thrown on all ranks
/// alike; main prints it once and exits with status 3.
class OutputError : public std::runtime_error
{
public:
  using std::runtime_error::runtime_error;
};

/// Why a file cannot be written, or nothing.
struct Obstacle
{
  std::string text;         ///< complete, without what to do; empty if there is none
  bool is_of_place = false; ///< another path would do: the input is wrong

  explicit operator bool() const { return !text.empty(); }
  /// @throw UserError or OutputError with the text and @p remedy, or the disk to look at.
  [[noreturn]] void raise(const std::string &remedy) const;
};

/// Of errno.
Obstacle obstacle_of_system(const std::string &file, int error);

/// When a file has come to the disk, where it outlives a loss of power: it stands under its name, or the next
/// bring_to_disk() returns. A disk takes milliseconds for that, as long as a step of a small scene.
enum class OnDisk { at_once, later };

/// A file is written beside its place under a name that begins with unfinished_prefix and then renamed, so
/// that whoever looks finds the old one or the new one, whole. Errors wait until finish().
class NewFile
{
public:
  /// @param beginning with which all files of this kind begin. A file that begins otherwise is somebody
  /// else's, and anything that is no regular file (a device, a link, a directory) is not replaced either.
  NewFile(const std::string &name, const std::string &beginning);
  ~NewFile(); ///< takes away what is not finished
  NewFile(const NewFile &) = delete;
  NewFile &operator=(const NewFile &) = delete;

  void append(const char *bytes, std::size_t n_bytes);
  void append(const std::string &bytes) { append(bytes.data(), bytes.size()); }
  /// From now on the file stands under its name, if nothing is returned.
  Obstacle finish(OnDisk on_disk = OnDisk::at_once);

private:
  void give_up(int error);

  const std::string name;
  std::string unfinished;
  int descriptor = -1;
  Obstacle obstacle;
};

/// Names of unfinished files of this process begin with it; also those of a process that has died.
std::string unfinished_prefix(const std::string &host, long process);
std::string host_name();

/// Make a directory for results, and those around it.
Obstacle make_directories(const std::string &directory);

/// What to do about an obstacle of the place.
constexpr const char *set_another_directory =
    "Set Directory in the subsection Output to a place where you may write.";

/// What stands at @p name and may not be replaced by a file that begins so.
Obstacle obstacle_to_replacing(const std::string &name, const std::string &beginning);

Obstacle write_file(const std::string &name, const std::string &beginning, const std::string &text,
                    OnDisk on_disk = OnDisk::at_once);

/// Add whole lines to a file that this process has written, until bring_to_disk().
/// @param size bytes that it had then
/// @return false if it is not as it was left or not all could be written: write_file() it anew
bool append_to_file(const std::string &name, std::size_t size, const std::string &lines);

/// All files of this process that may come later.
Obstacle bring_to_disk();

/// Take away a file of this kind, if there is one.
void remove_file(const std::string &name, const std::string &beginning);

} // namespace dovetail
