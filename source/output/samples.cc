// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/quadrature.h>
#include <dovetail/measure/interface_point.h>
#include <dovetail/output/samples.h>
#include <dovetail/output/shared_file.h>
#include <dovetail/scene/input_file.h>

#include <nlohmann/json.hpp>

#include <boost/serialization/string.hpp>

#include <filesystem>
#include <fstream>

namespace dovetail {

using nlohmann::ordered_json;

namespace {

const char *const format = "Dovetail samples 1";
const char *const beginning_of_samples = "{\"format\":\"Dovetail";

template <int dim>
std::vector<double> sample_domain(const Domain<dim> &domain, const Vector &solution)
{
  dealii::FEValues<dim> values(domain.mapping(), domain.scalar_element(),
                               gauss_rule<dim>(domain.scalar_element().reference_cell(), domain.degree + 1),
                               dealii::update_values | dealii::update_gradients |
                                   dealii::update_quadrature_points | dealii::update_JxW_values);
  const unsigned int n = domain.n_nodes();
  std::vector<double> numbers;
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      values.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
      domain.cell_dofs(cell, dofs);
      for (const unsigned int q : values.quadrature_point_indices()) {
        const auto &X = values.quadrature_point(q);
        for (unsigned int d = 0; d < dim; ++d)
          numbers.push_back(X[d]);
        numbers.push_back(domain.measure(values, q));
        for (unsigned int c = 0; c < domain.n_components(); ++c) {
          double value = 0;
          dealii::Tensor<1, dim> gradient;
          for (unsigned int a = 0; a < n; ++a) {
            const double unknown = solution(dofs[c * n + a]);
            value += unknown * values.shape_value(a, q);
            gradient += unknown * values.shape_grad(a, q);
          }
          numbers.push_back(value);
          for (unsigned int d = 0; d < dim; ++d)
            numbers.push_back(gradient[d]);
        }
      }
    }
  return numbers;
}

template <int dim>
std::vector<double> sample_interface(const Interface<dim> &interface, const Vector &solution, const double t)
{
  std::vector<double> numbers;
  InterfacePoint<dim> point(interface, t);
  point.for_each(solution, [&](const unsigned int q, const unsigned int) {
    const auto &X = interface.pairing().X(source, q);
    for (unsigned int d = 0; d < dim; ++d)
      numbers.push_back(X[d]);
    numbers.push_back(interface.pairing().weight(q));
    for (const auto &field : point.fields)
      numbers.insert(numbers.end(), field.numerical_flux.begin(), field.numerical_flux.end());
  });
  return numbers;
}

/// How many components there are, and the beginning of what the file says of a part.
template <typename Fields>
ordered_json describe(const std::string &name, const Fields &fields, unsigned int &n_components)
{
  ordered_json names = ordered_json::array();
  n_components = 0;
  for (const auto &field : fields) {
    names.push_back({{"name", field.name}, {"components", field.n_components}});
    n_components += field.n_components;
  }
  return {{"name", name}, {"fields", names}};
}

unsigned long count_points(const std::vector<double> &numbers, const unsigned int per_point,
                           const MPI_Comm &communicator)
{
  return dealii::Utilities::MPI::sum(static_cast<unsigned long>(numbers.size() / per_point), communicator);
}

std::vector<Samples::Part> read_parts(const ordered_json &list, const unsigned int per_component,
                                      const unsigned int dim, unsigned long long &position)
{
  std::vector<Samples::Part> parts;
  for (const auto &described : list) {
    Samples::Part part;
    part.name = described.at("name");
    part.source = described.value("source", "");
    part.destination = described.value("destination", "");
    part.n_points = described.at("points");
    part.n_numbers = dim + 1;
    for (const auto &field : described.at("fields")) {
      part.fields.emplace_back(field.at("name"), field.at("components"));
      part.n_numbers += part.fields.back().second * per_component;
    }
    part.position = position;
    position += part.n_points * part.n_numbers * sizeof(double);
    parts.push_back(part);
  }
  return parts;
}

/// @throw nlohmann's exceptions if the line says something else.
Samples parse(const std::string &line, const unsigned int dim, unsigned long long &size)
{
  const auto header = ordered_json::parse(line);
  if (header.at("format") != format)
    throw UserError("is of another version of Dovetail. Make it anew.");
  if (header.at("dimension") != dim)
    throw UserError("is of a scene in " + header.at("dimension").dump() + "D.");
  Samples samples;
  size = line.size() + 1;
  samples.domains = read_parts(header.at("domains"), 1 + dim, dim, size);
  samples.interfaces = read_parts(header.at("interfaces"), 1, dim, size);
  return samples;
}

} // namespace

template <int dim>
std::string side_in_words(const InterfaceSide<dim> &side)
{
  std::string words = side.domain->name + " :";
  for (const auto id : side.boundary_ids)
    words += " " + std::to_string(id);
  return words;
}

const Samples::Part *Samples::find(const std::vector<Part> &parts, const std::string &name)
{
  for (const Part &part : parts)
    if (part.name == name)
      return &part;
  return nullptr;
}

template <int dim>
void write_samples(const Model<dim> &model, const Vector &solution, const double t, const std::string &file)
{
  const MPI_Comm communicator = model.communicator;
  ordered_json header = {{"format", format}, {"dimension", dim}, {"time", t}};
  std::vector<std::vector<double>> numbers;
  unsigned int n_components = 0;
  header["domains"] = header["interfaces"] = ordered_json::array();
  for (const auto &domain : model.domains) {
    numbers.push_back(sample_domain(*domain, solution));
    ordered_json part = describe(domain->name, domain->fields(), n_components);
    part["points"] = count_points(numbers.back(), dim + 1 + n_components * (1 + dim), communicator);
    header["domains"].push_back(part);
  }
  for (const auto &interface : model.interfaces) {
    numbers.push_back(sample_interface(*interface, solution, t));
    ordered_json part = describe(interface->name, interface->fields, n_components);
    part["source"] = side_in_words(interface->sides[source]);
    part["destination"] = side_in_words(interface->sides[destination]);
    part["points"] = count_points(numbers.back(), dim + 1 + n_components, communicator);
    header["interfaces"].push_back(part);
  }

  const bool is_first = dealii::Utilities::MPI::this_mpi_process(communicator) == 0;
  SharedFile shared(file, beginning_of_samples, communicator);
  shared.append(is_first ? header.dump() + "\n" : "");
  for (const auto &part : numbers)
    shared.append(reinterpret_cast<const char *>(part.data()), part.size() * sizeof(double));
  if (const Obstacle obstacle = shared.finish())
    obstacle.raise("Set Samples in the subsection Output to another file.");
}

std::string obstacle_to_samples(const std::string &file, const std::string &reference,
                                const MPI_Comm &communicator)
{
  std::string problem;
  if (dealii::Utilities::MPI::this_mpi_process(communicator) == 0) {
    std::error_code error;
    const auto folder = std::filesystem::path(file).parent_path();
    if (!folder.empty() && !std::filesystem::is_directory(folder, error))
      problem = "The directory '" + folder.string() + "' does not exist.";
    else if (!reference.empty() && std::filesystem::equivalent(file, reference, error))
      problem = "It is the Reference as well.";
    else
      problem = obstacle_to_replacing(file, beginning_of_samples).text;
  }
  return dealii::Utilities::MPI::broadcast(communicator, problem);
}

Samples read_samples(const std::string &file, const unsigned int dim, const MPI_Comm &communicator)
{
  std::string line, problem;
  if (dealii::Utilities::MPI::this_mpi_process(communicator) == 0) {
    problem = obstacle_to_reading(file);
    if (!problem.empty())
      problem += " A run writes it with Samples = FILE in the subsection Output.";
    else {
      std::ifstream in(file, std::ios::binary);
      const std::string beginning = beginning_of_samples;
      std::string first(beginning.size(), ' ');
      in.read(&first[0], first.size());
      if (first != beginning || !std::getline(in, line))
        problem = "is no file of samples. A run writes one with Samples = FILE in the subsection Output.";
      line = first + line;
    }
    if (problem.empty())
      try {
        unsigned long long size = 0;
        parse(line, dim, size);
        std::error_code error;
        if (std::filesystem::file_size(file, error) != size)
          problem = "is not whole. Make it anew.";
      } catch (const UserError &error) {
        problem = error.what();
      } catch (const std::exception &) {
        problem = "is damaged in its first line. Make it anew.";
      }
  }
  problem = dealii::Utilities::MPI::broadcast(communicator, problem);
  if (!problem.empty())
    throw UserError(problem);
  line = dealii::Utilities::MPI::broadcast(communicator, line);
  unsigned long long size = 0;
  return parse(line, dim, size);
}

std::vector<double> read_points(const std::string &file, const Samples::Part &part, const unsigned long begin,
                                const unsigned long end)
{
  std::vector<double> numbers((end - begin) * part.n_numbers);
  std::ifstream in(file, std::ios::binary);
  in.seekg(part.position + begin * part.n_numbers * sizeof(double));
  in.read(reinterpret_cast<char *>(numbers.data()), numbers.size() * sizeof(double));
  AssertThrow(in, dealii::ExcMessage("The file of samples '" + file + "' has become shorter."));
  return numbers;
}

template std::string side_in_words(const InterfaceSide<2> &);
template std::string side_in_words(const InterfaceSide<3> &);
template void write_samples(const Model<2> &, const Vector &, double, const std::string &);
template void write_samples(const Model<3> &, const Vector &, double, const std::string &);

} // namespace dovetail
