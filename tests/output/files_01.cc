// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The files of ParaView and the report: which there are, which names they hold, and in which order the report
// has its keys. What is not asked for is not written.
//
// ranks: 1 2 3

#include "../measure/given_solution.h"

#include <dovetail/measure/measures.h>
#include <dovetail/output/paraview.h>
#include <dovetail/output/report.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

using namespace test;

namespace {

const std::string prm = R"(
set Materials = stuff
set Domains = a b, a_b
set Interfaces = seam
subsection Material stuff
  subsection Heat
    set Type = Fourier
    set Conductivity = 3
  end
  subsection Solid
    set Type = neo-Hookean
    set Young modulus = 1
    set Poisson ratio = 0.25
  end
end
subsection Domain a b
  set Material = stuff
  set Boundary conditions = warm, fixed
  subsection Mesh
    set Generator = subdivided_hyper_rectangle
    set Arguments = 2, 2, 2 : 0, 0, 0 : 1, 1, 1 : true
  end
  subsection Exact
    set temperature = 5 + x
    set displacement = x/10; y/10; 0
  end
  subsection Boundary condition warm
    set Type = value
    set Field = temperature
    set Boundary ids = 0
    set Expression = 5
  end
  subsection Boundary condition fixed
    set Type = value
    set Field = displacement
    set Boundary ids = 0
    set Expression = 0; 0; 0
  end
end
subsection Domain a_b
  set Material = stuff
  subsection Mesh
    set Generator = subdivided_hyper_rectangle
    set Arguments = 2, 3, 1 : 1, 0, 0 : 2, 1, 1 : true
  end
  subsection Exact
    set temperature = 5 + x
    set displacement = x/10; y/10; 0
  end
end
subsection Interface seam
  set Type = Nitsche
  set Source = a b : 1
  set Destination = a_b : 0
  set Weights = volume
  set Penalty = volume
end
subsection Output
  set Fields = solution, heat flux, Cauchy stress, von Mises
end
)";

std::string contents(const std::string &file)
{
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

/// The Name="…" of the data arrays in a file, and the lines of an index.
void print_names(const std::string &file)
{
  const std::string text = contents(file);
  std::cout << file << ":";
  std::set<std::string> names;
  for (std::size_t at = 0; (at = text.find("Name=\"", at)) != std::string::npos; ++at)
    names.insert(text.substr(at + 6, text.find('"', at + 6) - at - 6));
  for (const std::string &name : names)
    std::cout << " '" << name << "'";
  std::cout << std::endl;
}

void print_results(const std::string &directory, const std::string &report_file)
{
  std::cout << contents(directory + "/solution.pvd") << contents(directory + "/steps/step.0001.vtm");
  for (const std::string name : {"a_b.0000", "a_b_2.0001", "seam.0001"})
    print_names(directory + "/steps/" + name + ".vtu");
  const auto read = nlohmann::ordered_json::parse(contents(report_file));
  for (const auto &[key, value] : read.items())
    std::cout << key << std::endl;
  std::cout << "keys of an interface:";
  for (const auto &[key, value] : read["interfaces"]["seam"].items())
    std::cout << " '" << key << "'";
  std::cout << std::endl << "steps: " << read["steps"].dump() << std::endl;
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const GivenSolution<3> given(prm);
  const std::string directory = "results";
  const bool speaks = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0;

  Paraview<3> paraview(given.scene.subsection("Output"), given.model, directory);
  if (speaks)
    std::cout << "before: " << std::filesystem::exists(directory) << std::endl;
  paraview.write(0.5, given.solution);
  paraview.write(1, given.solution);

  // a directory where the index of all steps should be
  if (speaks)
    std::filesystem::create_directories("no_index/solution.pvd/occupied");
  Paraview<3> without_index(given.scene.subsection("Output"), given.model, "no_index");
  try {
    without_index.write(0.5, given.solution);
  } catch (const UserError &error) {
    if (speaks)
      std::cout << error.what() << std::endl;
  }
  if (speaks)
    std::cout << "files: " << paraview.n_files() << std::endl;

  Report report(directory, MPI_COMM_WORLD);
  report["domains"] = measure_domains(given.model, given.solution, 1.);
  report["interfaces"] = measure_interfaces(given.model, given.solution, *given.reactions);
  report.add_step(1, {2., std::nan("")}, {3});
  report.leave_out("cake: nobody is hungry");
  report.write();

  if (speaks)
    print_results(directory, report.file_name);
}
