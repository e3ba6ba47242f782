// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// One process at a time in a directory; locks of processes that have died are taken over, with what they
// left.

#include <dovetail/output/directory_lock.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sys/wait.h>
#include <unistd.h>

using namespace dovetail;

namespace {

/// With names that differ from run to run taken out.
std::string try_to_lock(const std::string &directory)
{
  const DirectoryLock lock(directory);
  std::string text = lock.obstacle() ? lock.obstacle().text : "locked";
  for (const std::string &name : {host_name(), std::to_string(getpid())})
    if (const auto at = text.find(" " + name); at != std::string::npos)
      text.replace(at + 1, name.size(), "…");
  return text;
}

void write_lock(const std::string &text)
{
  std::ofstream("d/dovetail.lock") << text;
}

/// Whose process is killed while it holds the lock and writes a file.
void die_while_writing()
{
  const pid_t child = fork();
  if (child == 0) {
    const DirectoryLock lock("d");
    NewFile file("d/report", "");
    file.append("half of");
    kill(getpid(), SIGKILL);
  }
  int status = 0;
  waitpid(child, &status, 0);
}

std::size_t n_entries()
{
  return std::distance(std::filesystem::directory_iterator("d"), std::filesystem::directory_iterator());
}

} // namespace

int main()
{
  std::filesystem::create_directory("d");
  {
    const DirectoryLock lock("d");
    std::cout << "first: " << !lock.obstacle() << ", second: " << try_to_lock("d") << std::endl;
  }
  std::cout << "released: " << n_entries() << ", then " << try_to_lock("d") << std::endl;

  die_while_writing();
  std::cout << "left by a dead process: " << n_entries();
  std::cout << ", then " << try_to_lock("d") << ", left: " << n_entries() << std::endl;

  write_lock(""); // a process died before it could write
  std::cout << "empty: " << try_to_lock("d") << std::endl;
  write_lock("Dovetail process 1 on host elsewhere\n");
  std::cout << "of another host: " << try_to_lock("d") << std::endl;
  write_lock("the key is under the mat\n");
  std::cout << "of somebody else: " << try_to_lock("d") << std::endl;
  std::filesystem::remove("d/dovetail.lock");
  std::filesystem::create_directory("d/dovetail.lock");
  std::cout << "a directory: " << try_to_lock("d") << std::endl;
  std::cout << "nowhere: " << try_to_lock("nowhere") << std::endl;
}
