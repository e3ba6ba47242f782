// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/interface/make_cover.h>

namespace dovetail {

namespace {

/// A node as one of the faces of the side around it sees it.
template <int dim>
struct NodeOfFace
{
  typename FaceLocator<dim>::Query query;
  dealii::types::global_dof_index node;
};

/// The nodes that this rank owns; it sees all faces around them.
template <int dim>
std::vector<NodeOfFace<dim>> nodes_of(const InterfaceSide<dim> &side)
{
  const Domain<dim> &domain = *side.domain;
  const auto &element = domain.scalar_element();
  const FaceShape<dim> shape(element.reference_cell(), 1);
  std::vector<NodeOfFace<dim>> nodes;
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &[cell, face, id] : domain.boundary_faces())
    if (side.boundary_ids.count(id) > 0) {
      domain.cell_dofs(domain.dof_cell(cell), dofs);
      const auto at = [&](const dealii::Point<dim> &unit_point) {
        return domain.mapping().transform_unit_to_real_cell(cell, unit_point);
      };
      const auto centre = shape.position_in_cell(face, shape.centre());
      dealii::Tensor<1, dim> outward = at(centre) - at(element.reference_cell().template barycenter<dim>());
      outward /= outward.norm();
      for (unsigned int a = 0; a < element.n_dofs_per_cell(); ++a)
        if (const auto node = dofs[a] - domain.first_dof;
            element.has_support_on_face(a, face) &&
            domain.dof_handler().locally_owned_dofs().is_element(node)) {
          const auto unit_point = element.unit_support_point(a);
          nodes.push_back({{at(unit_point + 1e-3 * (centre - unit_point)), outward}, node});
        }
    }
  return nodes;
}

} // namespace

template <int dim>
Cover<dim> make_cover(const Interface<dim> &interface, const unsigned int side, const MPI_Comm &communicator)
{
  Cover<dim> cover;
  cover.interface = interface.name;
  cover.is_permanent = !interface.has_toggle();
  cover.is_active = [&interface](const double t) { return interface.is_active(t); };
  for (const TiedField &field : interface.fields)
    cover.fields.insert(field.name);
  cover.faces = interface.pairing().covered_faces(side);

  const InterfaceSide<dim> &partner = interface.sides[1 - side];
  const FaceLocator<dim> locator(partner.domain->mesh(), partner.domain->mapping(),
                                 partner.domain->mapping_degree(), partner.boundary_ids,
                                 interface.search_radius(), communicator);
  const auto nodes = nodes_of(interface.sides[side]);
  std::vector<typename FaceLocator<dim>::Query> queries;
  for (const auto &node : nodes)
    queries.push_back(node.query);
  const auto matches = locator.locate(queries);
  for (unsigned int i = 0; i < nodes.size(); ++i)
    if (matches[i].found)
      cover.nodes.insert(nodes[i].node);
  for (unsigned int i = 0; i < nodes.size(); ++i)
    if (!matches[i].found)
      cover.nodes.erase(nodes[i].node);
  return cover;
}

template Cover<2> make_cover(const Interface<2> &, unsigned int, const MPI_Comm &);
template Cover<3> make_cover(const Interface<3> &, unsigned int, const MPI_Comm &);

} // namespace dovetail
