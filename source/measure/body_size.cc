// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/measure/body_size.h>

#include <dovetail/domain/quadrature.h>

#include <deal.II/base/mpi.h>
#include <deal.II/fe/fe_values.h>

#include <algorithm>
#include <limits>
#include <set>

namespace dovetail {

template <int dim>
BodySize<dim> measure_body(const Domain<dim> &domain, const MPI_Comm &communicator)
{
  const double infinity = std::numeric_limits<double>::infinity();
  const unsigned int n_points = domain.mapping_degree() + 1;
  const auto needed = domain.measure.update_flags();
  dealii::FEValues<dim> in_cell(domain.mapping(), domain.scalar_element(),
                                gauss_rule<dim>(domain.cell_shape(), n_points), needed);
  dealii::FEFaceValues<dim> on_face(domain.mapping(), domain.scalar_element(),
                                    gauss_rule<dim - 1>(domain.face_shape(), n_points), needed);
  BodySize<dim> size;
  for (unsigned int d = 0; d < dim; ++d) {
    size.low[d] = infinity;
    size.high[d] = -infinity;
  }
  for (const auto &cell : domain.mesh().active_cell_iterators())
    if (cell->is_locally_owned()) {
      in_cell.reinit(cell);
      for (const unsigned int q : in_cell.quadrature_point_indices())
        size.volume += domain.measure(in_cell, q);
    }
  for (const auto id : domain.boundary_ids())
    size.areas[id] = 0;
  for (const auto &face : domain.boundary_faces())
    if (face.cell->is_locally_owned()) {
      on_face.reinit(face.cell, face.number);
      for (const unsigned int q : on_face.quadrature_point_indices())
        size.areas[face.id] += domain.measure(on_face, q);
      for (const unsigned int v : face.cell->face(face.number)->vertex_indices())
        for (unsigned int d = 0; d < dim; ++d) {
          size.low[d] = std::min(size.low[d], face.cell->face(face.number)->vertex(v)[d]);
          size.high[d] = std::max(size.high[d], face.cell->face(face.number)->vertex(v)[d]);
        }
    }
  size.volume = dealii::Utilities::MPI::sum(size.volume, communicator);
  for (auto &entry : size.areas)
    entry.second = dealii::Utilities::MPI::sum(entry.second, communicator);
  for (unsigned int d = 0; d < dim; ++d) {
    size.low[d] = dealii::Utilities::MPI::min(size.low[d], communicator);
    size.high[d] = dealii::Utilities::MPI::max(size.high[d], communicator);
  }
  return size;
}

template <int dim>
ActingOn find_what_it_acts_on(const Domain<dim> &domain, const Condition<dim> &condition,
                              const MPI_Comm &communicator)
{
  ActingOn result;
  const bool prescribes = !condition.is_weak() && !condition.prescribed_components().empty();
  std::set<dealii::types::global_dof_index> unknowns;
  const auto owned = domain.dof_handler().locally_owned_dofs();
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &face : domain.boundary_faces())
    if (condition.boundary_ids.count(face.id) > 0) {
      result.n_faces += face.cell->is_locally_owned() ? 1 : 0;
      if (!prescribes)
        continue;
      domain.cell_dofs(domain.dof_cell(face.cell), dofs);
      for (const unsigned int c : condition.prescribed_components()) {
        const unsigned int component = condition.field.first_component + c;
        const auto &element = domain.layout().element(component);
        for (unsigned int a = 0; a < element.n_dofs_per_cell(); ++a) {
          const auto dof = dofs[domain.layout().first(component) + a];
          if (element.has_support_on_face(a, face.number) && owned.is_element(dof - domain.first_dof()))
            unknowns.insert(dof);
        }
      }
    }
  result.n_faces = dealii::Utilities::MPI::sum(result.n_faces, communicator);
  result.n_prescribed =
      dealii::Utilities::MPI::sum(static_cast<unsigned long>(unknowns.size()), communicator);
  if (condition.point())
    result.n_prescribed = condition.prescribed_components().size();
  else if (condition.constrains_normal())
    result.n_prescribed /= std::max<std::size_t>(1, condition.prescribed_components().size());
  return result;
}

template BodySize<2> measure_body(const Domain<2> &, const MPI_Comm &);
template BodySize<3> measure_body(const Domain<3> &, const MPI_Comm &);
template ActingOn find_what_it_acts_on(const Domain<2> &, const Condition<2> &, const MPI_Comm &);
template ActingOn find_what_it_acts_on(const Domain<3> &, const Condition<3> &, const MPI_Comm &);

} // namespace dovetail
