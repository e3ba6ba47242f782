// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Files are written whole or not at all and replace only those of their kind; all ranks know what went wrong.
//
// ranks: 1 3

#include <dovetail/output/shared_file.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <sys/resource.h>
#include <sys/stat.h>

using namespace dovetail;

namespace {

std::string contents(const std::string &file)
{
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

std::string write(const std::string &name)
{
  const Obstacle obstacle = write_file(name, "ours", "ours, new");
  return obstacle ? obstacle.text + (obstacle.is_of_place ? " (place)" : "") : "written";
}

/// What stands at a place and may not be replaced.
void replace_what_is_not_ours()
{
  std::ofstream("older") << "ours, old";
  std::ofstream("empty") << "";
  std::ofstream("foreign") << "somebody's thesis";
  std::filesystem::create_directory("directory");
  std::filesystem::create_symlink("older", "link");
  std::filesystem::create_symlink("nowhere", "dangling");
  mkfifo("pipe", 0666);
  for (const char *name : {"new", "older", "empty", "foreign", "directory", "link", "dangling", "pipe",
                           "/dev/null", "nowhere/file"})
    std::cout << name << ": " << write(name) << std::endl;
  std::cout << write(std::string(300, 'a')).substr(300) << std::endl;
  std::cout << "older: " << contents("older") << ", foreign: " << contents("foreign")
            << ", /dev/null is a device: " << std::filesystem::is_character_file("/dev/null") << std::endl;
  remove_file("older", "ours");
  remove_file("foreign", "ours");
  remove_file("directory", "ours");
  std::cout << "removed: " << !std::filesystem::exists("older") << std::filesystem::exists("foreign")
            << std::filesystem::exists("directory") << std::endl;
}

/// Lines are added only behind what this process has left there.
void add_lines()
{
  const std::string first = "ours, first\n", second = "second\n";
  write_file("grows", "ours", first, OnDisk::later);
  std::filesystem::create_symlink("grows", "link to it");
  std::cout << "added: " << append_to_file("grows", first.size(), second)
            << append_to_file("grows", first.size(), second) // its size is another one
            << append_to_file("link to it", first.size() + second.size(), second)
            << append_to_file("not there", 0, second) << append_to_file("pipe", 0, second)
            << append_to_file("grows", first.size() + second.size(), "") << ' ' << contents("grows");
  write_file("taken away", "ours", first, OnDisk::later);
  std::filesystem::remove("taken away");
  std::cout << "on the disk: " << !bring_to_disk() << !bring_to_disk() << ' ' << contents("grows");
}

/// A file of all ranks with more than one message of each, and one that outgrows what the system allows.
void write_together(const std::string &name, const std::size_t n_bytes, const bool speaks)
{
  const unsigned int rank = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD);
  SharedFile file(name, "A", MPI_COMM_WORLD);
  file.append(std::string(n_bytes, 'A' + rank));
  file.append("");
  file.append(std::string(2, 'a' + rank));
  const Obstacle obstacle = file.finish();
  const auto of_ranks = dealii::Utilities::MPI::gather(MPI_COMM_WORLD, obstacle.text);
  if (!speaks)
    return;
  std::cout << "alike: " << std::equal(of_ranks.begin() + 1, of_ranks.end(), of_ranks.begin()) << ' '
            << obstacle.text << std::endl;
  if (obstacle)
    return;
  const std::string text = contents(name);
  bool is_right = text.size() == of_ranks.size() * (n_bytes + 2);
  for (unsigned int r = 0; r < of_ranks.size(); ++r)
    is_right = is_right && text[r * n_bytes] == static_cast<char>('A' + r) &&
               text[(r + 1) * n_bytes - 1] == static_cast<char>('A' + r) &&
               text.substr(of_ranks.size() * n_bytes + 2 * r, 2) == std::string(2, 'a' + r);
  std::cout << "parts in order: " << is_right << std::endl;
}

void print_what_is_left()
{
  std::cout << "nothing is left: " << !std::filesystem::exists("too large");
  bool has_unfinished = false;
  for (const auto &entry : std::filesystem::directory_iterator("."))
    has_unfinished = has_unfinished || entry.path().filename().string()[0] == '.';
  std::cout << !has_unfinished << std::endl;
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const bool speaks = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0;
  if (speaks) {
    replace_what_is_not_ours();
    add_lines();
  }
  write_together("together", 20000000, speaks);

  // as if the disk were full
  std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit = {50000, RLIM_INFINITY};
  setrlimit(RLIMIT_FSIZE, &limit);
  write_together("too large", 200000, speaks);
  const std::string problem =
      first_problem(speaks ? "" : "of another rank", MPI_COMM_WORLD); // none on one rank
  if (speaks) {
    std::cout << "problem is known: "
              << (problem.empty() == (dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD) == 1))
              << std::endl;
    print_what_is_left();
    std::cout << "added to a full disk: "
              << append_to_file("together", std::filesystem::file_size("together"), "a") << std::endl;
    const auto size = std::filesystem::file_size("grows");
    std::cout << "a part of it: " << append_to_file("grows", size, std::string(100000, 'a'))
              << (std::filesystem::file_size("grows") == size) << std::endl;
  }
}
