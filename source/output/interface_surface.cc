// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/measure/gaps.h>
#include <dovetail/measure/interface_point.h>
#include <dovetail/output/interface_surface.h>

#include <deal.II/grid/reference_cell.h>

namespace dovetail {

namespace {

dealii::ReferenceCell shape_of(const unsigned int n_vertices)
{
  return n_vertices == 2   ? dealii::ReferenceCells::Line
         : n_vertices == 3 ? dealii::ReferenceCells::Triangle
                           : dealii::ReferenceCells::Quadrilateral;
}

} // namespace

template <int dim>
InterfaceSurface<dim>::InterfaceSurface(const Interface<dim> &interface)
    : interface(interface), own(interface.tie().integrates_on()[source] ? source : destination)
{
  const Pairing<dim> &pairing = interface.pairing();
  unsigned int n_points = 0; // of the side that is shown; they come first
  for (const auto &group : pairing.groups)
    if (group.side == own)
      n_points = group.end;
  patch_of_point.resize(n_points);
  for (const auto &piece : pairing.pieces)
    if (piece.begin < n_points) {
      std::fill(patch_of_point.begin() + piece.begin, patch_of_point.begin() + piece.end, patches.size());
      Patch patch;
      patch.patch_index = patches.size();
      patch.reference_cell = shape_of(piece.n_vertices);
      patch.n_subdivisions = 1;
      std::copy(piece.vertices.begin(), piece.vertices.begin() + piece.n_vertices,
                std::begin(patch.vertices));
      patches.push_back(patch);
    }
}

template <int dim>
void InterfaceSurface<dim>::update(const Vector &solution, const double t)
{
  const Pairing<dim> &pairing = interface.pairing();
  std::vector<double> area(patches.size(), 0.);
  std::vector<std::vector<double>> integrals(patches.size());
  InterfacePoint<dim> point(interface, t);
  std::vector<double> data;
  point.for_each(solution, [&](const unsigned int q, const unsigned int side) {
    if (side != own)
      return;
    data.clear();
    for (const auto &point_field : point.fields) {
      data.insert(data.end(), point_field.jump.begin(), point_field.jump.end());
      data.insert(data.end(), point_field.numerical_flux.begin(), point_field.numerical_flux.end());
    }
    data.push_back(signed_gap(interface, q));
    for (unsigned int d = 0; d < dim; ++d)
      data.push_back(pairing.N(own, q)[d]);
    if (interface.memory.has_joint()) {
      const auto memory = interface.memory.accepted(InterfaceMemory<dim>::joint, q);
      data.insert(data.end(), memory.begin(), memory.end());
    }

    const unsigned int p = patch_of_point[q];
    area[p] += pairing.weight(q);
    integrals[p].resize(data.size());
    for (unsigned int i = 0; i < data.size(); ++i)
      integrals[p][i] += pairing.weight(q) * data[i];
  });
  for (unsigned int p = 0; p < patches.size(); ++p) {
    const unsigned int n_vertices = patches[p].reference_cell.n_vertices();
    patches[p].data.reinit(integrals[p].size(), n_vertices);
    for (unsigned int i = 0; i < integrals[p].size(); ++i)
      for (unsigned int v = 0; v < n_vertices; ++v)
        patches[p].data(i, v) = integrals[p][i] / area[p];
  }
}

template <int dim>
std::vector<std::string> InterfaceSurface<dim>::get_dataset_names() const
{
  std::vector<std::string> names;
  for (const TiedField &field : interface.fields) {
    names.insert(names.end(), field.n_components, "jump " + field.name);
    names.insert(names.end(), field.n_components, "flux " + field.name);
  }
  names.push_back("gap");
  names.insert(names.end(), dim, "normal");
  for (const InternalVariable &variable : interface.tie().internal_variables())
    names.insert(names.end(), variable.n_components, variable.name);
  return names;
}

template class InterfaceSurface<2>;
template class InterfaceSurface<3>;

} // namespace dovetail
