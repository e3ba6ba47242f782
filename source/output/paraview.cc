// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/domain_picture.h>
#include <dovetail/output/paraview.h>
#include <dovetail/output/report.h>
#include <dovetail/output/uncovered_points.h>

#include <cctype>
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

dealii::DataOutBase::VtkFlags flags_at(const double time)
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

constexpr const char *beginning_of_index = "<?xml version=\"1.0\"?>\n<VTKFile type=\"";

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
      writes(output.read<bool>("Paraview", true, "Write files for ParaView [-]"))
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
  if (times.empty() && dealii::Utilities::MPI::this_mpi_process(model.communicator) == 0)
    remove_file(directory + "/solution.pvd", beginning_of_index); // its steps will be those of this run
  for (unsigned int i = 0; i < model.interfaces.size(); ++i)
    show_uncovered_points(i);
}

template <int dim>
void Paraview<dim>::show_uncovered_points(const unsigned int interface)
{
  const auto &pairing = model.interfaces[interface]->pairing();
  const std::string file = directory + "/uncovered_" + blocks[model.domains.size() + interface].stem + ".vtu";
  if (pairing.coverage().n_uncovered > 0)
    write_picture(file, dealii::DataOutBase::VtkFlags(),
                  [&]() { return UncoveredPoints<dim>(pairing).piece({}); });
  else if (dealii::Utilities::MPI::this_mpi_process(model.communicator) == 0)
    remove_file(file, beginning_of_vtu); // of an earlier run
}

template <int dim>
Paraview<dim>::~Paraview() = default;

template <int dim>
void Paraview<dim>::read_fields(const Section &output)
{
  const std::vector<std::string> known = {"solution", "heat flux", "Cauchy stress", "von Mises"};
  const auto asked = output.read<std::vector<std::string>>(
      "Fields", {"solution"},
      "The fields in the files, any of: solution, heat flux, Cauchy stress, von Mises [-]");
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

/// Letters, digits, '-' and '_' only, not too many for a file, and no name twice, also where upper and lower
/// case are the same.
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
    safe.resize(std::min<std::size_t>(safe.size(), 100));
    block.stem = safe;
    for (unsigned int i = 2; !taken.insert(lower_case(block.stem)).second; ++i)
      block.stem = safe + "_" + std::to_string(i);
  }
}

template <int dim>
void Paraview<dim>::check(const Obstacle &obstacle) const
{
  if (obstacle)
    Obstacle{"The files for ParaView cannot be written. " + obstacle.text, obstacle.is_of_place}.raise(
        set_another_directory);
}

/// What one rank cannot show, nobody shows: the others must not wait for its piece.
template <int dim>
template <typename Show>
void Paraview<dim>::write_picture(const std::string &file, const dealii::DataOutBase::VtkFlags &flags,
                                  const Show &show)
{
  PieceOfPicture piece;
  std::string problem;
  try {
    piece = show();
  } catch (const std::exception &error) {
    problem = error.what();
  }
  problem = first_problem(problem, model.communicator);
  if (!problem.empty())
    throw OutputError("The file '" + file + "' for ParaView cannot be made: " + problem);
  check(write_vtu(file, piece, flags, model.communicator));
  ++n_written;
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
  const auto flags = flags_at(time);
  for (const Block &block : blocks)
    write_picture(directory + "/steps/" + file_of(block.stem, times.size(), ".vtu"), flags, [&]() {
      if (block.domain != nullptr)
        return DomainPicture<dim>(*block.domain, fields, solution, time).piece(flags);
      block.surface->update(solution, time);
      return block.surface->piece(flags);
    });
  times.push_back(time);
  write_indices();
}

template <int dim>
void Paraview<dim>::write_indices()
{
  const unsigned int last = times.size() - 1;
  std::ostringstream of_step;
  of_step << beginning_of_index << "vtkMultiBlockDataSet\" version=\"1.0\">\n"
          << "<vtkMultiBlockDataSet>\n";
  for (unsigned int b = 0; b < blocks.size(); ++b)
    of_step << "<DataSet index=\"" << b << "\" name=\"" << escape(blocks[b].name) << "\" file=\""
            << file_of(blocks[b].stem, last, ".vtu") << "\"/>\n";
  of_step << "</vtkMultiBlockDataSet>\n</VTKFile>\n";
  check(write_on_first_rank(directory + "/steps/" + file_of("step", last, ".vtm"), beginning_of_index,
                            of_step.str(), model.communicator));

  std::ostringstream of_all;
  of_all << beginning_of_index << "Collection\" version=\"0.1\">\n<Collection>\n" << std::setprecision(16);
  for (unsigned int step = 0; step <= last; ++step)
    of_all << "<DataSet timestep=\"" << times[step] << "\" file=\"steps/" << file_of("step", step, ".vtm")
           << "\"/>\n";
  of_all << "</Collection>\n</VTKFile>\n";
  check(
      write_on_first_rank(directory + "/solution.pvd", beginning_of_index, of_all.str(), model.communicator));
  n_written += 2;
}

template class Paraview<2>;
template class Paraview<3>;

} // namespace dovetail
