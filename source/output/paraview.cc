// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/domain_picture.h>
#include <dovetail/output/paraview.h>
#include <dovetail/output/report.h>
#include <dovetail/output/uncovered_points.h>

#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iomanip>
#include <sstream>

namespace dovetail {

namespace {

template <int dim>
bool some_domain_has(const Model<dim> &model, const std::string &field)
{
  return std::any_of(model.domains.begin(), model.domains.end(),
                     [&](const auto &domain) { return domain->material.find_field(field) != nullptr; });
}

dealii::DataOutBase::VtkFlags flags(const double time)
{
  dealii::DataOutBase::VtkFlags result;
  result.time = time;
  result.compression_level = decltype(result.compression_level)::best_speed;
  return result;
}

/// In the folder of the steps.
std::string file_of(const std::string &stem, const unsigned int step, const std::string &ending)
{
  std::ostringstream name;
  name << stem << '.' << std::setw(4) << std::setfill('0') << step << ending;
  return name.str();
}

/// Written beside and then renamed, so that a file is whole whenever somebody opens it.
void write_file(const std::string &name, const std::string &text)
{
  std::ofstream file(name + ".new");
  file << text << std::flush;
  if (!file || std::rename((name + ".new").c_str(), name.c_str()) != 0) {
    const std::string reason = std::strerror(errno);
    std::remove((name + ".new").c_str());
    throw std::runtime_error("cannot write '" + name + "': " + reason);
  }
}

std::string escape(const std::string &text)
{
  std::string result;
  for (const char c : text)
    result += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : std::string(1, c);
  return result;
}

} // namespace

template <int dim>
Paraview<dim>::Paraview(const Section &output, const Model<dim> &model, const std::string &directory)
    : model(model), directory(directory),
      writes(output.read<bool>("Paraview", true, "Write files that ParaView opens [-]"))
{
  read_fields(output);
}

template <int dim>
void Paraview<dim>::prepare()
{
  for (const auto &domain : model.domains) {
    blocks.emplace_back();
    blocks.back().name = domain->name;
    blocks.back().domain = domain.get();
  }
  for (const auto &interface : model.interfaces) {
    blocks.emplace_back();
    blocks.back().name = interface->name;
    blocks.back().surface = std::make_unique<InterfaceSurface<dim>>(*interface);
  }
  name_files();
  make_directory(directory + "/steps", model.communicator);
  for (unsigned int i = 0; i < model.interfaces.size(); ++i) {
    const auto &pairing = model.interfaces[i]->pairing();
    const std::string file = directory + "/uncovered_" + blocks[model.domains.size() + i].stem + ".vtu";
    if (pairing.coverage().n_uncovered > 0) {
      checked([&]() { UncoveredPoints<dim>(pairing).write_vtu_in_parallel(file, model.communicator); });
      ++n_written;
    } else if (dealii::Utilities::MPI::this_mpi_process(model.communicator) == 0)
      std::remove(file.c_str()); // of an earlier run
  }
}

template <int dim>
Paraview<dim>::~Paraview() = default;

template <int dim>
void Paraview<dim>::read_fields(const Section &output)
{
  const std::vector<std::string> known = {"solution", "heat flux", "Cauchy stress", "von Mises"};
  const auto asked = output.read<std::vector<std::string>>(
      "Fields", {"solution"}, "What the files show, of: solution, heat flux, Cauchy stress, von Mises [-]");
  for (const std::string &field : asked) {
    output.check(std::find(known.begin(), known.end(), field) != known.end(), "Fields",
                 "has '" + field + "', but known are " + comma_separated(known) + ". " +
                     did_you_mean(field, known));
    output.check(field == "solution" || field == "heat flux" || some_domain_has(model, "displacement"),
                 "Fields",
                 "asks for " + field + ", but no material has a solid law. Remove it from the list.");
    output.check(field != "heat flux" || some_domain_has(model, "temperature"), "Fields",
                 "asks for heat flux, but no material has a heat law. Remove it from the list.");
  }
  fields = {asked.begin(), asked.end()};
}

/// Letters, digits, '-' and '_' only, and no name twice, also where upper and lower case are the same.
template <int dim>
void Paraview<dim>::name_files()
{
  std::set<std::string> taken;
  for (Block &block : blocks) {
    std::string safe;
    for (const char c : block.name)
      safe += std::isalnum(static_cast<unsigned char>(c)) || c == '-' ? c : '_';
    const auto lower_case = [](std::string text) {
      std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
      return text;
    };
    block.stem = safe;
    for (unsigned int i = 2; !taken.insert(lower_case(block.stem)).second; ++i)
      block.stem = safe + "_" + std::to_string(i);
  }
}

/// What fails on one rank, fails on all.
template <int dim>
template <typename Write>
void Paraview<dim>::checked(const Write &write) const
{
  std::string problem;
  try {
    write();
  } catch (const dealii::ExceptionBase &error) {
    std::ostringstream text;
    error.print_info(text);
    problem = dealii::Utilities::trim(text.str());
    problem = problem.substr(0, problem.find(".\n")); // what follows is meant for programmers
  } catch (const std::exception &error) {
    problem = error.what();
  }
  for (const std::string &of_rank : dealii::Utilities::MPI::all_gather(model.communicator, problem))
    if (!of_rank.empty())
      throw UserError("The files for ParaView cannot be written to '" + directory + "': " + of_rank +
                      ". Is the disk full, or Directory in the subsection Output not yours to write?");
}

template <int dim>
void Paraview<dim>::write(const double time, const Vector &solution)
{
  if (!writes)
    return;
  if (blocks.empty())
    prepare();
  if (!times.empty() && times.back() == time)
    times.pop_back();
  checked([&]() { write_blocks(time, solution); });
  times.push_back(time);
  checked([&]() {
    if (dealii::Utilities::MPI::this_mpi_process(model.communicator) == 0)
      write_indices();
  });
  n_written += blocks.size() + 2;
}

template <int dim>
void Paraview<dim>::write_blocks(const double time, const Vector &solution)
{
  for (const Block &block : blocks) {
    const std::string file = directory + "/steps/" + file_of(block.stem, times.size(), ".vtu");
    if (block.domain != nullptr) {
      DomainPicture<dim> picture(*block.domain, fields, solution, time);
      picture.set_flags(flags(time));
      picture.write_vtu_in_parallel(file, model.communicator);
    } else {
      block.surface->update(solution, time);
      block.surface->set_flags(flags(time));
      block.surface->write_vtu_in_parallel(file, model.communicator);
    }
  }
}

template <int dim>
void Paraview<dim>::write_indices() const
{
  const unsigned int last = times.size() - 1;
  std::ostringstream of_step;
  of_step << "<?xml version=\"1.0\"?>\n<VTKFile type=\"vtkMultiBlockDataSet\" version=\"1.0\">\n"
          << "<vtkMultiBlockDataSet>\n";
  for (unsigned int b = 0; b < blocks.size(); ++b)
    of_step << "<DataSet index=\"" << b << "\" name=\"" << escape(blocks[b].name) << "\" file=\""
            << file_of(blocks[b].stem, last, ".vtu") << "\"/>\n";
  of_step << "</vtkMultiBlockDataSet>\n</VTKFile>\n";
  write_file(directory + "/steps/" + file_of("step", last, ".vtm"), of_step.str());

  std::ostringstream of_all;
  of_all << "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n"
         << std::setprecision(16);
  for (unsigned int step = 0; step <= last; ++step)
    of_all << "<DataSet timestep=\"" << times[step] << "\" file=\"steps/" << file_of("step", step, ".vtm")
           << "\"/>\n";
  of_all << "</Collection>\n</VTKFile>\n";
  write_file(directory + "/solution.pvd", of_all.str());
}

template class Paraview<2>;
template class Paraview<3>;

} // namespace dovetail
