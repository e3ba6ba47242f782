// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/domain_picture.h>
#include <dovetail/output/new_file.h>
#include <dovetail/output/paraview.h>

#include <dovetail/material/transient.h>
#include <dovetail/measure/probe_names.h>
#include <dovetail/output/report.h>
#include <dovetail/output/uncovered_picture.h>

#include <cctype>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <set>
#include <sstream>

namespace dovetail {

namespace {

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

/// The files that an index names, without their folder.
std::vector<std::string> files_in(const std::string &index)
{
  std::ifstream stream(index);
  std::vector<std::string> files;
  const std::string before = "file=\"";
  for (std::string line; std::getline(stream, line);)
    if (const auto begin = line.find(before); begin != std::string::npos) {
      const std::string path = line.substr(begin + before.size());
      files.push_back(std::filesystem::path(path.substr(0, path.find('"'))).filename().string());
    }
  return files;
}

/// The pictures of an earlier run, as its indices name them, and the indices. Other files stay.
void remove_series(const std::string &directory)
{
  const std::string series = directory + "/solution.pvd", steps = directory + "/steps/";
  if (obstacle_to_replacing(series, beginning_of_index))
    return;
  for (const std::string &step : files_in(series)) {
    if (obstacle_to_replacing(steps + step, beginning_of_index))
      continue;
    for (const std::string &picture : files_in(steps + step))
      remove_file(steps + picture, beginning_of_vtu);
    remove_file(steps + step, beginning_of_index);
  }
  remove_file(series, beginning_of_index);
}

} // namespace

template <int dim>
Paraview<dim>::Paraview(const Section &output, const Model<dim> &model, const std::string &directory)
    : model(model), directory(directory),
      writes(output.read<bool>("Paraview", true, "Write files for ParaView [-]"))
{
  if (const std::string words = output.top().peek("Units"); !words.empty())
    given_units.emplace(words);
  read_fields(output);
  add_unit("gap", "m");
  for (const auto &interface : model.interfaces)
    for (const TiedField &field : interface->fields) {
      add_unit("jump " + field.name, units_of_field(field.name).value);
      add_unit("flux " + field.name, units_of_field(field.name).flux);
    }
}

template <int dim>
void Paraview<dim>::prepare()
{
  for (const auto &domain : model.domains)
    add_block(*domain, false);
  for (const auto &interface : model.interfaces)
    if (shows_interfaces) {
      blocks.emplace_back();
      blocks.back().name = interface->name;
      blocks.back().surface = std::make_unique<InterfaceSurface<dim>>(*interface);
    }
  for (const auto &domain : model.domains)
    add_block(*domain, true);
  name_files();
  make_directory(directory + "/steps", model.communicator);
  if (times.empty() && dealii::Utilities::MPI::this_mpi_process(model.communicator) == 0)
    remove_series(directory); // its steps will be those of this run
  for (unsigned int i = 0; i < model.interfaces.size() && shows_interfaces; ++i)
    show_uncovered_points(i);
}

template <int dim>
void Paraview<dim>::show_uncovered_points(const unsigned int interface)
{
  const auto &pairing = model.interfaces[interface]->pairing();
  const std::string file = directory + "/uncovered_" + blocks[model.domains.size() + interface].stem + ".vtu";
  if (pairing.coverage().n_uncovered > 0)
    write_picture(file, dealii::DataOutBase::VtkFlags(),
                  [&]() { return UncoveredPicture<dim>(pairing).piece(dealii::DataOutBase::VtkFlags()); });
  else if (dealii::Utilities::MPI::this_mpi_process(model.communicator) == 0)
    remove_file(file, beginning_of_vtu); // of an earlier run
}

template <int dim>
Paraview<dim>::~Paraview() = default;

template <int dim>
void Paraview<dim>::read_fields(const Section &output)
{
  const auto asked = output.read<std::vector<std::string>>(
      "Fields", {"solution"}, "What the files show: " + QuantityCatalogue<dim>::help() + " [-]");
  for (auto name = asked.begin(); name != asked.end(); ++name) {
    if (std::find(asked.begin(), name, *name) != name)
      continue; // a second time
    const auto &member = QuantityCatalogue<dim>::find(*name, output, "Fields");
    bool has_domain = false;
    for (const auto &domain : model.domains)
      if (member.field.empty() || domain->material.find_field(member.field) != nullptr) {
        quantities.push_back(member.create(*name, *domain));
        quantities_of[domain.get()].push_back(quantities.back().get());
        for (const auto &array : quantities.back()->arrays())
          add_unit(array.name, member.unit().empty() ? units_of_field(array.name).value : member.unit());
        has_domain = true;
      }
    output.check(!has_domain || !quantities.back()->is_stored() || is_transient(output), "Fields",
                 "asks for " + *name +
                     ", which only transient scenes have: set Kind = transient in the subsection Steps, or "
                     "leave it out.");
    output.check(has_domain, "Fields",
                 "asks for " + *name + ", but no material has a " + law_of_field(member.field) +
                     ". Remove it from the list.");
  }
  output.check(
      quantities.empty() || !has_motion() || (is_transient(output) && has_inertia(output)), "Fields",
      "asks for velocities, which only bodies with inertia have: set Inertia = true in the subsection "
      "Steps of a transient scene.");
  for (const auto &[domain, shown] : quantities_of) {
    std::set<std::string> names;
    for (const Quantity<dim> *quantity : shown)
      for (const auto &array : quantity->arrays())
        output.check(names.insert(array.name).second, "Fields",
                     "shows two arrays with the name " + array.name + " for the domain " + domain->name +
                         ": a field and a quantity. Leave one of them out.");
  }
}

template <int dim>
void Paraview<dim>::add_unit(const std::string &array, const std::string &in_si)
{
  const std::string unit = given_units ? given_units->of(in_si) : "";
  if (!unit.empty())
    units[array] = unit;
}

/// A block for the quantities of the boundary only if there are some.
template <int dim>
void Paraview<dim>::add_block(const Domain<dim> &domain, const bool is_of_boundary)
{
  Block block;
  block.name = is_of_boundary ? domain.name + " boundary" : domain.name;
  block.domain = &domain;
  block.is_of_boundary = is_of_boundary;
  for (const Quantity<dim> *quantity : quantities_of[&domain])
    if (quantity->is_of_boundary() == is_of_boundary)
      block.quantities.push_back(quantity);
  if (!is_of_boundary || !block.quantities.empty())
    blocks.push_back(std::move(block));
}

template <int dim>
bool Paraview<dim>::needs_reactions() const
{
  return writes && std::any_of(quantities.begin(), quantities.end(),
                               [](const auto &quantity) { return quantity->is_of_nodes(); });
}

template <int dim>
bool Paraview<dim>::has_motion() const
{
  return writes && std::any_of(quantities.begin(), quantities.end(),
                               [](const auto &quantity) { return quantity->is_of_motion(); });
}

template <int dim>
void Paraview<dim>::set_velocity(const Vector *velocity)
{
  for (const auto &quantity : quantities)
    quantity->set_velocity(velocity);
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
PieceOfPicture Paraview<dim>::show(Block &block, const dealii::DataOutBase::VtkFlags &flags,
                                   const double time, const Vector &solution) const
{
  if (block.surface) {
    block.surface->update(solution, time);
    return block.surface->piece(flags);
  }
  return block.is_of_boundary
             ? BoundaryPicture<dim>(*block.domain, block.quantities, solution, time).piece(flags)
             : DomainPicture<dim>(*block.domain, block.quantities, solution, time).piece(flags);
}

template <int dim>
bool Paraview<dim>::has_lagrange_cells(const Block &block)
{
  return block.domain != nullptr && block.domain->degree > 2 && !block.domain->has_simplices() &&
         (dim == 3 || !block.is_of_boundary);
}

template <int dim>
void Paraview<dim>::write(const double time, const Vector &solution, const Reactions<dim> *reactions)
{
  if (!writes)
    return;
  if (blocks.empty())
    prepare();
  if (!numbers_steps && !times.empty() && times.back() == time)
    times.pop_back();
  Assert(reactions != nullptr || !needs_reactions(), dealii::ExcMessage("The reactions are asked for."));
  for (const auto &quantity : quantities)
    if (quantity->is_of_nodes())
      quantity->set_reactions(*reactions);
  const double time_of_series = numbers_steps ? times.size() + 1 : time;
  for (Block &block : blocks) {
    auto flags = flags_at(time_of_series);
    flags.physical_units = units;
    flags.write_higher_order_cells = has_lagrange_cells(block);
    write_picture(directory + "/steps/" + file_of(block.stem, times.size(), ".vtu"), flags,
                  [&]() { return show(block, flags, time, solution); });
  }
  times.push_back(time_of_series);
  write_index_of_step();
  write_series();
  n_written += 2;
}

/// What a run that was killed has written after its last checkpoint leaves the list at once.
template <int dim>
void Paraview<dim>::go_on_from(const std::vector<double> &times_so_far)
{
  times = times_so_far;
  if (writes && !times.empty())
    write_series();
}

template <int dim>
void Paraview<dim>::write_index_of_step() const
{
  const unsigned int last = times.size() - 1;
  std::ostringstream step_index;
  step_index << beginning_of_index << "vtkMultiBlockDataSet\" version=\"1.0\">\n"
             << "<vtkMultiBlockDataSet>\n";
  for (unsigned int b = 0; b < blocks.size(); ++b)
    step_index << "<DataSet index=\"" << b << "\" name=\"" << escape(blocks[b].name) << "\" file=\""
               << file_of(blocks[b].stem, last, ".vtu") << "\"/>\n";
  step_index << "</vtkMultiBlockDataSet>\n</VTKFile>\n";
  check(write_on_first_rank(directory + "/steps/" + file_of("step", last, ".vtm"), beginning_of_index,
                            step_index.str(), model.communicator, OnDisk::later));
}

template <int dim>
void Paraview<dim>::write_series() const
{
  std::ostringstream series;
  series << beginning_of_index << "Collection\" version=\"0.1\">\n<Collection>\n" << std::setprecision(16);
  for (unsigned int step = 0; step < times.size(); ++step)
    series << "<DataSet timestep=\"" << times[step] << "\" file=\"steps/" << file_of("step", step, ".vtm")
           << "\"/>\n";
  series << "</Collection>\n</VTKFile>\n";
  check(write_on_first_rank(directory + "/solution.pvd", beginning_of_index, series.str(), model.communicator,
                            OnDisk::later));
}

template class Paraview<2>;
template class Paraview<3>;

} // namespace dovetail
