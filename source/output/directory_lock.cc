// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/directory_lock.h>
#include <dovetail/output/shared_file.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <sstream>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace dovetail {

namespace {

const char *const signature = "Dovetail";

/// "Dovetail process 123 on host somewhere"
struct Owner
{
  long process = 0;
  std::string host;

  static Owner parse(const std::string &text)
  {
    Owner owner;
    std::string word;
    std::istringstream(text) >> word >> word >> owner.process >> word >> word >> owner.host;
    return owner;
  }

  std::string in_words() const { return "process " + std::to_string(process) + " on host " + host; }
};

std::string read_all(const int descriptor)
{
  char text[512];
  const ssize_t n = pread(descriptor, text, sizeof(text), 0);
  return {text, static_cast<std::size_t>(n > 0 ? n : 0)};
}

/// Somebody may have taken it away between opening and locking.
bool still_stands_at(const std::string &file, const int descriptor)
{
  struct stat here, there;
  return fstat(descriptor, &here) == 0 && lstat(file.c_str(), &there) == 0 && here.st_ino == there.st_ino &&
         here.st_dev == there.st_dev;
}

} // namespace

DirectoryLock::DirectoryLock(const std::string &directory)
    : directory(directory), file(directory + "/dovetail.lock")
{
  for (unsigned int attempt = 0; attempt < 20 && !take(); ++attempt)
    usleep(50000);
  if (!problem && !is_held)
    problem = {"The directory '" + directory +
                   "' is used by another run: " + Owner::parse(read_all(descriptor)).in_words() + ".",
               true};
}

DirectoryLock::~DirectoryLock()
{
  if (is_held)
    unlink(file.c_str());
  if (descriptor >= 0)
    close(descriptor);
}

bool DirectoryLock::take()
{
  if (descriptor >= 0)
    close(descriptor);
  descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
  if (descriptor < 0) {
    problem = obstacle_of_system(file, errno);
    return true;
  }
  const Obstacle foreign = obstacle_to_replacing(file, signature);
  if (foreign) {
    problem = foreign;
    return true;
  }
  const bool is_locked = flock(descriptor, LOCK_EX | LOCK_NB) == 0;
  if (!is_locked && errno == EWOULDBLOCK)
    return false;
  if (!still_stands_at(file, descriptor))
    return false;
  const std::string owner = read_all(descriptor);
  if (!owner.empty()) {
    const Owner before = Owner::parse(owner);
    const bool is_of_this_host = before.host == host_name();
    // a file system without locks
    const bool lives = !is_locked && is_of_this_host && before.process != getpid() &&
                       (kill(before.process, 0) == 0 || errno == EPERM);
    if (!is_of_this_host || lives) {
      problem = {"The directory '" + directory + "' is used by another run: " + before.in_words() +
                     ". If no run goes on there, remove '" + file + "'.",
                 true};
      return true;
    }
    clear_after(owner);
  }
  sign();
  return true;
}

/// What a process was writing when it died.
void DirectoryLock::clear_after(const std::string &owner) const
{
  const Owner dead = Owner::parse(owner);
  const std::string prefix = unfinished_prefix(dead.host, dead.process);
  for (const std::string &folder : {directory, directory + "/steps"}) {
    std::error_code error;
    for (const auto &entry : std::filesystem::directory_iterator(folder, error))
      if (entry.path().filename().string().rfind(prefix, 0) == 0)
        std::filesystem::remove_all(entry.path(), error);
  }
}

void DirectoryLock::sign()
{
  Owner own;
  own.process = getpid();
  own.host = host_name();
  const std::string text = std::string(signature) + " " + own.in_words() + "\n";
  if (ftruncate(descriptor, 0) != 0 ||
      pwrite(descriptor, text.data(), text.size(), 0) != static_cast<ssize_t>(text.size())) {
    problem = obstacle_of_system(file, errno);
    unlink(file.c_str());
    return;
  }
  is_held = true;
}

std::unique_ptr<DirectoryLock> lock_directory(const std::string &directory, const MPI_Comm &communicator)
{
  std::unique_ptr<DirectoryLock> lock;
  if (dealii::Utilities::MPI::this_mpi_process(communicator) == 0)
    lock = std::make_unique<DirectoryLock>(directory);
  if (const Obstacle obstacle = agree(lock ? lock->obstacle() : Obstacle(), communicator))
    obstacle.raise(wait_for_the_other_run);
  return lock;
}

} // namespace dovetail
