// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/new_file.h>
#include <dovetail/scene/user_error.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <set>
#include <sys/stat.h>
#include <unistd.h>

namespace dovetail {

namespace {

/// Up to the last '/', which belongs to it.
std::string folder_of(const std::string &name)
{
  return name.substr(0, name.rfind('/') + 1);
}

bool begins_with(const std::string &file, const std::string &beginning)
{
  std::ifstream in(file, std::ios::binary);
  std::string found(beginning.size(), '\0');
  in.read(&found[0], found.size());
  return found == beginning;
}

/// A renamed file is lost with the power unless its folder is on the disk as well. Not all systems can do it.
void bring_folder_to_disk(const std::string &folder)
{
  const int descriptor = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0)
    return;
  fsync(descriptor);
  close(descriptor);
}

/// Names of files that only the system has so far.
std::set<std::string> &files_of_system()
{
  static std::set<std::string> files;
  return files;
}

/// errno, or 0
int flush_to_disk(const int descriptor)
{
  return fsync(descriptor) == 0 || errno == EINVAL ? 0 : errno; // EINVAL: there is no disk
}

} // namespace

void Obstacle::raise(const std::string &remedy) const
{
  if (is_of_place)
    throw UserError(text + " " + remedy);
  throw OutputError(text + " Is the disk full?");
}

Obstacle obstacle_of_system(const std::string &file, const int error)
{
  const std::set<int> place_errors = {EACCES, EPERM,        EROFS, ENOENT, ENOTDIR, EISDIR, EEXIST,
                                      ELOOP,  ENAMETOOLONG, EBUSY, ENXIO,  ETXTBSY, EINVAL};
  return {"The file '" + file + "' cannot be written: " + std::strerror(error) + ".",
          place_errors.count(error) > 0};
}

Obstacle make_directories(const std::string &directory)
{
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (!error)
    return {};
  return {"The directory '" + directory + "' for the results cannot be made: " + error.message() + ".",
          obstacle_of_system(directory, error.value()).is_of_place};
}

std::string host_name()
{
  char name[256] = "";
  gethostname(name, sizeof(name) - 1);
  return name;
}

std::string unfinished_prefix(const std::string &host, const long process)
{
  return ".dovetail-" + host.substr(0, 64) + "-" + std::to_string(process) + "-";
}

Obstacle obstacle_to_replacing(const std::string &name, const std::string &beginning)
{
  struct stat status;
  if (lstat(name.c_str(), &status) != 0)
    return errno == ENOENT ? Obstacle() : obstacle_of_system(name, errno);
  const auto refuse = [&](const std::string &reason) {
    return Obstacle{"'" + name + "' is not replaced: it is " + reason + ".", true};
  };
  if (S_ISDIR(status.st_mode))
    return refuse("a directory");
  if (S_ISLNK(status.st_mode))
    return refuse("a symbolic link");
  if (!S_ISREG(status.st_mode))
    return refuse("no file but a pipe, a socket or a device");
  if (status.st_size > 0 && !begins_with(name, beginning))
    return refuse("not of the kind that would be written there");
  return {};
}

NewFile::NewFile(const std::string &name, const std::string &beginning)
    : name(name), obstacle(obstacle_to_replacing(name, beginning))
{
  static unsigned int n_files = 0;
  if (obstacle)
    return;
  unfinished = folder_of(name) + unfinished_prefix(host_name(), getpid()) + std::to_string(n_files++);
  unlink(unfinished.c_str()); // of a process that had this number before
  descriptor = open(unfinished.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    unfinished.clear();
    give_up(errno);
  }
}

NewFile::~NewFile()
{
  if (descriptor >= 0)
    close(descriptor);
  if (!unfinished.empty())
    unlink(unfinished.c_str());
}

void NewFile::give_up(const int error)
{
  if (!obstacle)
    obstacle = obstacle_of_system(name, error);
}

void NewFile::append(const char *bytes, std::size_t n_bytes)
{
  while (!obstacle && n_bytes > 0) {
    const ssize_t n_written = ::write(descriptor, bytes, n_bytes);
    if (n_written < 0 && errno == EINTR)
      continue;
    if (n_written <= 0)
      give_up(n_written == 0 ? EIO : errno);
    else {
      bytes += n_written;
      n_bytes -= n_written;
    }
  }
}

Obstacle NewFile::finish(const OnDisk on_disk)
{
  if (!obstacle && on_disk == OnDisk::at_once)
    if (const int error = flush_to_disk(descriptor))
      give_up(error);
  if (descriptor >= 0 && close(descriptor) != 0)
    give_up(errno);
  descriptor = -1;
  if (!obstacle && std::rename(unfinished.c_str(), name.c_str()) != 0)
    give_up(errno);
  if (!obstacle) {
    unfinished.clear();
    if (on_disk == OnDisk::later)
      files_of_system().insert(name);
    else
      bring_folder_to_disk(folder_of(name));
  }
  return obstacle;
}

Obstacle write_file(const std::string &name, const std::string &beginning, const std::string &text,
                    const OnDisk on_disk)
{
  NewFile file(name, beginning);
  file.append(text);
  return file.finish(on_disk);
}

bool append_to_file(const std::string &name, const std::size_t size, const std::string &lines)
{
  const int descriptor = open(name.c_str(), O_WRONLY | O_APPEND | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0)
    return false;
  struct stat status;
  const bool is_as_left = fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) &&
                          status.st_nlink == 1 && static_cast<std::size_t>(status.st_size) == size;
  const ssize_t n_written = is_as_left ? ::write(descriptor, lines.data(), lines.size()) : -1;
  const bool is_done = n_written == static_cast<ssize_t>(lines.size());
  if (n_written > 0 && !is_done && ftruncate(descriptor, size) != 0) // a part of a number is another one
    unlink(name.c_str());
  files_of_system().insert(name);
  return close(descriptor) == 0 && is_done;
}

Obstacle bring_to_disk()
{
  Obstacle obstacle;
  std::set<std::string> folders;
  for (const std::string &name : files_of_system()) {
    const int descriptor = open(name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    const int error = descriptor < 0 ? errno : flush_to_disk(descriptor);
    if (descriptor >= 0)
      close(descriptor);
    const bool is_taken_away = descriptor < 0 && (error == ENOENT || error == ENOTDIR || error == ELOOP);
    if (error != 0 && !is_taken_away && !obstacle)
      obstacle = obstacle_of_system(name, error);
    folders.insert(folder_of(name));
  }
  files_of_system().clear();
  for (const std::string &folder : folders)
    bring_folder_to_disk(folder);
  return obstacle;
}

void remove_file(const std::string &name, const std::string &beginning)
{
  if (!obstacle_to_replacing(name, beginning))
    unlink(name.c_str());
}

} // namespace dovetail
