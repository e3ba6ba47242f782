// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/bytes.h>
#include <dovetail/output/cell_records.h>
#include <dovetail/output/checkpoint.h>
#include <dovetail/output/point_records.h>
#include <dovetail/scene/user_error.h>

#include <deal.II/base/mpi.h>
#include <deal.II/grid/cell_id.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

namespace {

using Index = dealii::types::global_dof_index;
using nlohmann::ordered_json;

std::string unknowns_of(const std::string &domain)
{
  return "unknowns of " + domain;
}

std::string multipliers_of(const std::string &interface, const TiedField &field)
{
  return "multipliers of " + interface + ", " + field.name;
}

/// Centres and sizes of all cells, in a sum in which each cell has a weight of its own; the sum of their
/// magnitudes; and their material and boundary ids, in a sum like the first one.
template <int dim>
std::array<double, 3> fingerprint(const Domain<dim> &domain, const MPI_Comm &communicator)
{
  std::array<double, 3> sums = {{0, 0, 0}};
  for (const auto &cell : domain.mesh().active_cell_iterators())
    if (cell->is_locally_owned()) {
      unsigned int mixed = 17;
      for (const unsigned int word : cell->id().template to_binary<dim>())
        mixed = (mixed ^ word) * 16777619u + 2531011u;
      const double weight = 1 + (mixed >> 8) / 16777216.;
      double value = cell->diameter();
      for (unsigned int d = 0; d < dim; ++d)
        value += (2 + d) * cell->center()[d];
      sums[0] += weight * value;
      sums[1] += cell->diameter() + cell->center().norm();
      double ids = cell->material_id();
      for (const unsigned int f : cell->face_indices())
        if (cell->face(f)->at_boundary())
          ids += (3 + 2 * f) * (1. + cell->face(f)->boundary_id());
      sums[2] += weight * ids;
    }
  for (double &sum : sums)
    sum = dealii::Utilities::MPI::sum(sum, communicator);
  return sums;
}

/// Of the files that formulas name, wherever they lie.
std::vector<std::uint64_t> sums_of_tables(const SceneText &text)
{
  std::vector<std::uint64_t> sums;
  for (const std::string &content : text.tables())
    sums.push_back(checksum(content));
  std::sort(sums.begin(), sums.end());
  return sums;
}

template <int dim>
ordered_json fingerprints(const Model<dim> &model)
{
  ordered_json meshes = ordered_json::object();
  for (const auto &domain : model.domains)
    meshes[domain->name] = {{"cells", domain->mesh().n_global_active_cells()},
                            {"unknowns", domain->dof_handler().n_dofs()},
                            {"sum", fingerprint(*domain, model.communicator)}};
  return meshes;
}

/// Numbers of the vectors at unknowns with the indices @p places there.
NumbersOfUnknowns numbers_at(const std::vector<Index> &unknowns, const std::vector<Index> &places,
                             const std::map<std::string, Vector> &vectors)
{
  NumbersOfUnknowns own;
  own.n = vectors.size();
  own.unknowns = unknowns;
  for (const Index place : places)
    for (const auto &[name, vector] : vectors)
      own.numbers.push_back(vector(place));
  return own;
}

template <int dim>
std::vector<Index> owned_unknowns(const Domain<dim> &domain)
{
  std::vector<Index> unknowns;
  for (const Index dof : domain.dof_handler().locally_owned_dofs())
    unknowns.push_back(domain.first_dof() + dof);
  return unknowns;
}

std::vector<Index> from(const Index first, const std::size_t n)
{
  std::vector<Index> indices(n);
  for (std::size_t i = 0; i < n; ++i)
    indices[i] = first + i;
  return indices;
}

template <int dim>
std::vector<Index> unknowns_with_multiplier(const Interface<dim> &interface, const TiedField &field)
{
  const Multipliers<dim> *multipliers = interface.tie().parts().multipliers;
  return multipliers == nullptr ? std::vector<Index>()
                                : multipliers->unknowns_with_multiplier(interface, field);
}

/// By field; negative where there are none.
template <int dim>
std::vector<std::vector<double>> pack_weak_penalties(const Domain<dim> &domain)
{
  std::vector<std::vector<double>> packed(domain.mesh().n_active_cells());
  for (const auto &[key, gamma] : domain.weak_penalties) {
    packed[key.second].resize(domain.fields().size(), -1.);
    for (unsigned int f = 0; f < domain.fields().size(); ++f)
      if (domain.fields()[f].name == key.first)
        packed[key.second][f] = gamma;
  }
  return packed;
}

template <int dim>
void add_records(const Domain<dim> &domain, const std::map<std::string, Vector> &vectors,
                 RecordFile::Records &records)
{
  const CellRecords<dim> cells(domain);
  const auto unknowns = owned_unknowns(domain);
  records[unknowns_of(domain.name)] = cells.pack(numbers_at(unknowns, unknowns, vectors));
  records["penalties of " + domain.name] = cells.pack(pack_weak_penalties(domain));
  if (domain.memory)
    records["memory of " + domain.name] = cells.pack(domain.memory->pack());
}

/// By point, from what the memory and the tie have. @return how many numbers each of them gives
template <int dim>
std::array<unsigned int, 2> add_records(const Interface<dim> &interface,
                                        const std::map<std::string, Vector> &vectors,
                                        const MPI_Comm &communicator, RecordFile::Records &records)
{
  const CellRecords<dim> cells(*interface.sides[destination].domain);
  for (const TiedField &field : interface.fields) {
    const auto unknowns = unknowns_with_multiplier(interface, field);
    records[multipliers_of(interface.name, field)] =
        cells.pack(numbers_at(unknowns, from(field.first_multiplier, unknowns.size()), vectors));
  }
  const unsigned int n_points = interface.pairing().n_points();
  const std::vector<double> penalties = interface.tie().pack_points(interface);
  std::array<unsigned int, 2> n = {
      {0, n_points > 0 ? static_cast<unsigned int>(penalties.size() / n_points) : 0}};
  std::vector<double> numbers;
  for (unsigned int q = 0; q < n_points; ++q) {
    const std::vector<double> remembered = interface.memory.pack(q);
    n[0] = remembered.size();
    numbers.insert(numbers.end(), remembered.begin(), remembered.end());
    numbers.insert(numbers.end(), penalties.begin() + q * n[1], penalties.begin() + (q + 1) * n[1]);
  }
  if (dealii::Utilities::MPI::max(n[0] + n[1], communicator) > 0)
    records["points of " + interface.name] = PointRecords<dim>(interface).pack(n[0] + n[1], numbers);
  return {{dealii::Utilities::MPI::max(n[0], communicator), dealii::Utilities::MPI::max(n[1], communicator)}};
}

} // namespace

bool may_change(const std::string &path)
{
  for (const char *section : {"Output/", "Newton/", "Linear solver/", "Study/", "Probe "})
    if (path.rfind(section, 0) == 0)
      return true;
  for (const char *entry : {"Probes", "Plugins", "Adaptive cycles", "Adaptive share", "Adaptive unknowns",
                            "Steps/End time", "Steps/Number of steps", "Steps/Adaptive", "Steps/Tolerance",
                            "Steps/Smallest step", "Steps/Largest step", "Steps/Largest number of steps"})
    if (path == entry)
      return true;
  const std::string file_of_mesh = "/Mesh/File"; // another place of the same mesh
  return path.size() > file_of_mesh.size() &&
         path.compare(path.size() - file_of_mesh.size(), file_of_mesh.size(), file_of_mesh) == 0;
}

template <int dim>
Obstacle write_checkpoint(const std::string &file, const SceneText &text, const Model<dim> &model,
                          const SavedState &state)
{
  RecordFile::Records records;
  ordered_json points = ordered_json::object(), names = ordered_json::array();
  for (const auto &domain : model.domains)
    add_records(*domain, state.vectors, records);
  for (const auto &interface : model.interfaces)
    points[interface->name] = add_records(*interface, state.vectors, model.communicator, records);
  for (const auto &[name, vector] : state.vectors)
    names.push_back(name);
  return RecordFile::write(file,
                           {{"version", DOVETAIL_VERSION},
                            {"ranks", dealii::Utilities::MPI::n_mpi_processes(model.communicator)},
                            {"numbers", state.numbers},
                            {"vectors", names},
                            {"meshes", fingerprints(model)},
                            {"points", points},
                            {"tables", sums_of_tables(text)},
                            {"scene", text.used()}},
                           records, model.communicator);
}

template <int dim>
Checkpoint<dim>::Checkpoint(const std::string &file, const MPI_Comm &communicator)
    : name(file), communicator(communicator), file(file, communicator)
{
}

template <int dim>
void Checkpoint<dim>::check_scene(const SceneText &text) const
{
  text.check_unchanged(
      file.header()["scene"].get<std::map<std::string, std::string>>(), may_change,
      "A run that goes on from a checkpoint may have another End time, Number of steps and sizes of the "
      "steps, "
      "other Probes, Output and settings of the solvers, and nothing else. Set the former value, or run the "
      "scene from its beginning, without --resume.");
  if (file.header()["tables"].get<std::vector<std::uint64_t>>() != sums_of_tables(text))
    throw UserError("The checkpoint '" + name +
                    "' is of other tables: a file that a formula names has changed. "
                    "Take the former file, or run the scene from its beginning, without --resume.");
}

template <int dim>
void Checkpoint<dim>::refuse_mesh(const std::string &what) const
{
  throw UserError("The checkpoint '" + name + "' is of another mesh: " + what +
                  " Take the former mesh, or run the scene from its beginning, without --resume.");
}

template <int dim>
void Checkpoint<dim>::check_meshes(const Model<dim> &model) const
{
  const ordered_json &before = file.header()["meshes"], now = fingerprints(model);
  for (const auto &domain : model.domains) {
    const ordered_json &one = before[domain->name], &other = now[domain->name];
    const unsigned long n_before = one["cells"], n_now = other["cells"];
    if (n_before != n_now)
      refuse_mesh("the domain " + domain->name + " had " + std::to_string(n_before) + " cells and has " +
                  std::to_string(n_now) + ".");
    const std::array<double, 3> sum = one["sum"], other_sum = other["sum"];
    if (one["unknowns"] != other["unknowns"] || std::abs(sum[0] - other_sum[0]) > 1e-9 * sum[1])
      refuse_mesh("cells of the domain " + domain->name + " lie at other places.");
    if (std::abs(sum[2] - other_sum[2]) > 1e-9 * (1 + std::abs(sum[2])))
      refuse_mesh("boundary ids or material ids of the domain " + domain->name + " have changed.");
  }
}

template <int dim>
void Checkpoint<dim>::read_unknowns(const Model<dim> &model, const std::string &record,
                                    const Domain<dim> &domain, std::map<std::string, Vector> &vectors,
                                    const std::vector<Index> &unknowns,
                                    const std::vector<Index> &places) const
{
  NumbersOfUnknowns found;
  found.n = vectors.size();
  const CellRecords<dim> cells(domain);
  file.for_each_part(record, [&](const std::string &part) { cells.unpack(part, found); });
  found = found.sent_to_owners(*model.numbering, communicator);
  std::map<Index, Index> place_of;
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    place_of[unknowns[i]] = places[i];
  std::size_t n_set = 0;
  for (std::size_t i = 0; i < found.unknowns.size(); ++i)
    if (const auto place = place_of.find(found.unknowns[i]); place != place_of.end()) {
      ++n_set;
      std::size_t j = i * found.n;
      for (auto &[name_of_vector, vector] : vectors)
        vector(place->second) = found.numbers[j++];
    }
  if (dealii::Utilities::MPI::max(n_set != unknowns.size() ? 1 : 0, communicator) > 0)
    refuse_mesh("not all " + record + " are there.");
}

template <int dim>
std::map<std::string, Vector> Checkpoint<dim>::vectors(const Model<dim> &model, const Vector &layout) const
{
  std::map<std::string, Vector> result;
  for (const std::string name_of_vector : file.header()["vectors"])
    result[name_of_vector] = layout;
  for (const auto &domain : model.domains) {
    const auto unknowns = owned_unknowns(*domain);
    read_unknowns(model, unknowns_of(domain->name), *domain, result, unknowns, unknowns);
  }
  for (const auto &interface : model.interfaces)
    for (const TiedField &field : interface->fields) {
      const auto unknowns = unknowns_with_multiplier(*interface, field);
      read_unknowns(model, multipliers_of(interface->name, field), *interface->sides[destination].domain,
                    result, unknowns, from(field.first_multiplier, unknowns.size()));
    }
  for (auto &[name_of_vector, vector] : result)
    vector.compress(dealii::VectorOperation::insert);
  return result;
}

template <int dim>
std::vector<std::vector<double>> Checkpoint<dim>::read_cells(const std::string &record,
                                                             const Domain<dim> &domain) const
{
  std::vector<std::vector<double>> packed(domain.mesh().n_active_cells());
  const CellRecords<dim> cells(domain);
  file.for_each_part(record, [&](const std::string &part) { cells.unpack(part, packed); });
  return packed;
}

template <int dim>
std::vector<double> Checkpoint<dim>::read_points(const std::string &record,
                                                 const Interface<dim> &interface) const
{
  const std::array<unsigned int, 2> n = file.header()["points"][interface.name];
  if (n[0] + n[1] == 0)
    return {};
  const auto numbers = PointRecords<dim>(interface).unpack(n[0] + n[1], file, record);
  const bool has_gap = numbers.size() != (n[0] + n[1]) * interface.pairing().n_points();
  if (dealii::Utilities::MPI::max(has_gap ? 1 : 0, communicator) > 0)
    refuse_mesh("points of the interface " + interface.name + " lie at other places.");
  return numbers;
}

template <int dim>
void Checkpoint<dim>::restore_memory(Model<dim> &model) const
{
  for (const auto &domain : model.domains)
    if (domain->memory) {
      const auto packed = read_cells("memory of " + domain->name, *domain);
      const std::size_t size =
          domain->cell_quadrature().size() * (dim + domain->material.initial_memory().size());
      bool has_gap = false;
      for (const auto &cell : domain->mesh().active_cell_iterators())
        if (cell->is_locally_owned())
          has_gap = has_gap || packed[cell->active_cell_index()].size() != size;
      if (dealii::Utilities::MPI::max(has_gap ? 1 : 0, communicator) > 0)
        refuse_mesh("the domain " + domain->name + " remembers something else.");
      domain->memory->unpack(packed);
    }
  for (const auto &interface : model.interfaces) {
    const std::array<unsigned int, 2> n = file.header()["points"][interface->name];
    const auto numbers = read_points("points of " + interface->name, *interface);
    if (n[0] > 0)
      for (unsigned int q = 0; q < interface->pairing().n_points(); ++q)
        interface->memory.unpack(
            q, {numbers.begin() + q * (n[0] + n[1]), numbers.begin() + q * (n[0] + n[1]) + n[0]});
  }
}

template <int dim>
void Checkpoint<dim>::restore_penalties(Model<dim> &model) const
{
  for (const auto &domain : model.domains) {
    const auto packed = read_cells("penalties of " + domain->name, *domain);
    for (unsigned int cell = 0; cell < packed.size(); ++cell)
      for (unsigned int f = 0; f < packed[cell].size(); ++f)
        if (packed[cell][f] >= 0)
          domain->weak_penalties[{domain->fields()[f].name, cell}] = packed[cell][f];
  }
  for (const auto &interface : model.interfaces) {
    const std::array<unsigned int, 2> n = file.header()["points"][interface->name];
    const auto numbers = read_points("points of " + interface->name, *interface);
    std::vector<double> penalties;
    for (unsigned int q = 0; n[1] > 0 && q < interface->pairing().n_points(); ++q)
      penalties.insert(penalties.end(), numbers.begin() + q * (n[0] + n[1]) + n[0],
                       numbers.begin() + (q + 1) * (n[0] + n[1]));
    if (n[1] > 0)
      interface->tie().unpack_points(*interface, penalties);
  }
}

template Obstacle write_checkpoint(const std::string &, const SceneText &, const Model<2> &,
                                   const SavedState &);
template Obstacle write_checkpoint(const std::string &, const SceneText &, const Model<3> &,
                                   const SavedState &);
template class Checkpoint<2>;
template class Checkpoint<3>;

} // namespace dovetail
