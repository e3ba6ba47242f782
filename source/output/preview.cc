// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/preview.h>

#include <dovetail/measure/gaps.h>
#include <dovetail/output/domain_picture.h>
#include <dovetail/output/picture.h>
#include <dovetail/output/report.h>

#include <deal.II/grid/reference_cell.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>
#include <sstream>

namespace dovetail {

namespace {

constexpr const char *beginning_of_preview = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\"";

/// Flat pieces of surfaces with one number of each kind for each.
template <int dim>
class SurfacePreview : public Picture<dim - 1, dim>
{
public:
  using Patch = dealii::DataOutBase::Patch<dim - 1, dim>;

  explicit SurfacePreview(const std::vector<std::string> &names) : names(names) {}

  template <typename VertexOf>
  void add(const unsigned int n_vertices, const VertexOf &vertex, const std::vector<double> &numbers)
  {
    Patch patch;
    patch.patch_index = patches.size();
    patch.reference_cell = n_vertices == 2   ? dealii::ReferenceCells::Line
                           : n_vertices == 3 ? dealii::ReferenceCells::Triangle
                                             : dealii::ReferenceCells::Quadrilateral;
    patch.n_subdivisions = 1;
    patch.data.reinit(numbers.size(), n_vertices);
    for (unsigned int v = 0; v < n_vertices; ++v) {
      patch.vertices[v] = vertex(v);
      for (unsigned int i = 0; i < numbers.size(); ++i)
        patch.data(i, v) = numbers[i];
    }
    patches.push_back(patch);
  }

protected:
  const std::vector<Patch> &get_patches() const override { return patches; }
  std::vector<std::string> get_dataset_names() const override { return names; }
  std::vector<std::tuple<unsigned int, unsigned int, std::string,
                         dealii::DataComponentInterpretation::DataComponentInterpretation>>
  get_nonscalar_data_ranges() const override
  {
    return group_by_name(names);
  }

private:
  const std::vector<std::string> names;
  std::vector<Patch> patches;
};

/// From 1; 0: none.
template <typename Things, typename Holds>
double number_of_first(const Things &things, const Holds &holds)
{
  const auto found = std::find_if(things.begin(), things.end(), holds);
  return found == things.end() ? 0. : 1. + (found - things.begin());
}

template <int dim>
SurfacePreview<dim> preview_of_body(const Model<dim> &model, const Domain<dim> &body)
{
  SurfacePreview<dim> preview({"boundary id", "condition", "interface"});
  for (const auto &face : body.boundary_faces())
    if (face.cell->is_locally_owned()) {
      const auto shape = face.cell->face(face.number);
      const double condition = number_of_first(body.conditions(), [&](const auto &candidate) {
        return candidate->boundary_ids.count(face.id) > 0;
      });
      const double interface = number_of_first(model.interfaces, [&](const auto &candidate) {
        return std::any_of(candidate->sides.begin(), candidate->sides.end(), [&](const auto &side) {
          return side.domain == &body && side.boundary_ids.count(face.id) > 0;
        });
      });
      preview.add(shape->n_vertices(), [&](const unsigned int v) { return shape->vertex(v); },
                  {static_cast<double>(face.id), condition, interface});
    }
  return preview;
}

template <int dim>
SurfacePreview<dim> preview_of_interface(const Interface<dim> &interface)
{
  SurfacePreview<dim> preview({"gap", "angle"});
  const Pairing<dim> &pairing = interface.pairing();
  for (const auto &piece : pairing.pieces)
    if (piece.begin < piece.end) {
      const double cosine = -(pairing.N(source, piece.begin) * pairing.N(destination, piece.begin));
      preview.add(piece.n_vertices, [&](const unsigned int v) { return piece.vertices[v]; },
                  {signed_gap(interface, piece.begin),
                   180 / dealii::numbers::PI * std::acos(std::clamp(cosine, -1., 1.))});
    }
  return preview;
}

/// The names of files and blocks of a preview, and their index.
class PreviewIndex
{
public:
  /// @return the file without directory; letters, digits, '-' and '_', none twice
  std::string add(const std::string &name)
  {
    std::string stem;
    for (const char c : name.substr(0, 100))
      stem += std::isalnum(static_cast<unsigned char>(c)) || c == '-' ? c : '_';
    stem = std::to_string(n_files++) + "_" + stem;
    std::string escaped;
    for (const char c : name)
      escaped += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : std::string(1, c);
    lines << "<DataSet timestep=\"0\" part=\"" << n_files - 1 << "\" name=\"" << escaped << "\" file=\"check/"
          << stem << ".vtu\"/>\n";
    return "check/" + stem + ".vtu";
  }
  std::string text() const
  {
    return std::string(beginning_of_preview) + " version=\"0.1\">\n<Collection>\n" + lines.str() +
           "</Collection>\n</VTKFile>\n";
  }

private:
  unsigned int n_files = 0;
  std::ostringstream lines;
};

void check_preview(const Obstacle &obstacle)
{
  if (obstacle)
    Obstacle{"The preview for ParaView cannot be written. " + obstacle.text, obstacle.is_of_place}.raise(
        set_another_directory);
}

} // namespace

template <int dim>
void write_preview(const Model<dim> &model, const std::string &directory)
{
  make_directory(directory + "/check", model.communicator);
  PreviewIndex index;
  dealii::DataOutBase::VtkFlags flags;
  flags.compression_level = decltype(flags.compression_level)::best_speed;
  const auto write = [&](const std::string &name, const SurfacePreview<dim> &preview) {
    check_preview(
        write_vtu(directory + "/" + index.add(name), preview.piece(flags), flags, model.communicator));
  };
  for (const auto &body : model.domains)
    write(body->name, preview_of_body(model, *body));
  for (const auto &interface : model.interfaces)
    write(interface->name, preview_of_interface(*interface));
  check_preview(
      write_on_first_rank(directory + "/check.pvd", beginning_of_preview, index.text(), model.communicator));
  check_preview(bring_to_disk(model.communicator));
}

template void write_preview(const Model<2> &, const std::string &);
template void write_preview(const Model<3> &, const std::string &);

} // namespace dovetail
