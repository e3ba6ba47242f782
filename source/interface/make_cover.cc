// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/interface/make_cover.h>

namespace dovetail {

namespace {

/// A node as one of the faces around it sees it, from a point towards one of the face's corners.
template <int dim>
struct Look
{
  typename FaceLocator<dim>::Query query;
  std::array<unsigned int, 4> node; ///< as in Cover::nodes
};

template <int dim>
std::vector<Look<dim>> looks_at_nodes(const InterfaceSide<dim> &side, const unsigned int space)
{
  const Domain<dim> &domain = *side.domain;
  const auto &element = domain.layout().element_of_space(space);
  const FaceShape<dim> shape(element.reference_cell(), 1);
  std::vector<Look<dim>> looks;
  for (const auto &[cell, face, id] : domain.boundary_faces())
    if (side.belongs(cell, id)) {
      const auto at = [&cell = cell, &domain](const dealii::Point<dim> &unit_point) {
        return domain.mapping().transform_unit_to_real_cell(cell, unit_point);
      };
      const auto centre = shape.position_in_cell(face, shape.centre());
      dealii::Tensor<1, dim> outward = at(centre) - at(element.reference_cell().template barycenter<dim>());
      outward /= outward.norm();
      for (unsigned int a = 0; a < element.n_dofs_per_cell(); ++a)
        if (element.has_support_on_face(a, face))
          for (unsigned int corner = 0; corner < shape.n_corners(); ++corner) {
            // not along the rim, which the neighbouring face shares
            const auto unit_point = element.unit_support_point(a);
            const auto target = centre + 0.9 * (shape.position_in_cell(face, shape.corner(corner)) - centre);
            looks.push_back({{at(unit_point + 1e-3 * (target - unit_point)) + side.shift, outward,
                              cell->face(face)->diameter()},
                             {{cell->active_cell_index(), face, space, a}}});
          }
    }
  return looks;
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
    cover.fields.insert(field.names[side]);
  cover.faces = interface.pairing().covered_faces(side);

  const FaceLocator<dim> locator = interface.make_locator(1 - side, communicator);
  std::set<unsigned int> spaces;
  for (const TiedField &field : interface.fields)
    spaces.insert(interface.sides[side].domain->layout().space(field.first_component[side]));
  std::vector<Look<dim>> looks;
  for (const unsigned int space : spaces) {
    const auto space_looks = looks_at_nodes(interface.sides[side], space);
    looks.insert(looks.end(), space_looks.begin(), space_looks.end());
  }
  std::vector<typename FaceLocator<dim>::Query> queries;
  for (const auto &look : looks)
    queries.push_back(look.query);
  const auto matches = locator.locate(queries);
  interface.work() += locator.work();
  for (const auto &look : looks)
    cover.nodes.insert(look.node);
  for (unsigned int i = 0; i < looks.size(); ++i)
    if (!matches[i].found)
      cover.nodes.erase(looks[i].node);
  return cover;
}

template Cover<2> make_cover(const Interface<2> &, unsigned int, const MPI_Comm &);
template Cover<3> make_cover(const Interface<3> &, unsigned int, const MPI_Comm &);

} // namespace dovetail
