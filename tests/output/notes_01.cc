// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Each note is told once, and again at the end if the log has gone on for more than a screen since. Of a
// name, the log has eight, and the report all.
//
// ranks: 1

#include <dovetail/output/notes.h>

#include <deal.II/base/mpi.h>

#include <iostream>
#include <sstream>

using namespace dovetail;

namespace {

const NoteName of_first("one name", "at first"), of_second("other name", "after it");

} // namespace

int main(int argc, char **argv)
{
  const dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  for (const unsigned int n_lines : {0, 10, 30}) {
    std::ostringstream text;
    std::streambuf *before = std::cout.rdbuf(text.rdbuf());
    Log log(MPI_COMM_WORLD);
    Notes notes(log);
    notes.add(of_first("first"));
    for (unsigned int i = 0; i < n_lines; ++i)
      log.line("  Newton");
    notes.add(of_second("second"));
    notes.add(of_first("first"));
    log.line("results");
    notes.repeat();
    std::cout.rdbuf(before);
    std::istringstream lines(text.str());
    std::string line;
    std::cout << n_lines << " lines:";
    while (std::getline(lines, line))
      if (line != "  Newton")
        std::cout << " '" << line << "'";
    std::cout << std::endl;
  }
  Log log(MPI_COMM_WORLD);
  Notes notes(log);
  for (unsigned int i = 0; i < 12; ++i)
    notes.add(of_first("interface " + std::to_string(i)));
  notes.add(of_second("second"));
  std::cout << notes.texts().size() << " notes" << std::endl;
}
