// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Pointwise continuity at the support points X of the destination side, through the map to the source side:
//
//     B_dst(X) = B_src(X') + grad B_src(X').(X - X') = sum_a (phi_a(X') + grad phi_a(X').(X - X')) B_a
//
// (the second term only over a gap), as constraints that are condensed out of the system. It passes the patch
// test only if the destination's trace space contains the source's, so the finer side should be the
// destination.
//
//     subsection Interface seam
//       set Type        = pointwise
//       set Source      = left : 1
//       set Destination = right : 0
//     end

#include <dovetail/interface/interface.h>
#include <dovetail/interface/side_ratios.h>

#include <deal.II/base/mpi.h>
#include <deal.II/dofs/dof_tools.h>

#include <cmath>
#include <sstream>

namespace dovetail {

namespace {

template <int dim>
class Pointwise : public Tie<dim>
{
public:
  explicit Pointwise(const Section &) {}

  std::array<bool, 2> integrates_on() const override { return {{false, true}}; }
  bool is_strong() const override { return true; }
  bool has_constant_tangent(const Interface<dim> &) const override { return true; }
  std::string description() const override { return "the destination's unknowns follow the source"; }
  void add_constraints(const Interface<dim> &interface, TieConstraints &constraints,
                       const MPI_Comm &communicator) override;
  std::vector<std::string> notes() const override;

  bool has_multipliers() const override { return true; }
  void find_multipliers(const Interface<dim> &interface, const typename Tie<dim>::Owned &solution,
                        const typename Tie<dim>::Owned &force, const MPI_Comm &communicator) override;
  bool knows_resultant() const override { return !transmitted.empty(); }
  std::vector<double> resultant(const unsigned int field) const override { return transmitted[field]; }

private:
  /// A support point of the destination and its unknowns, one per component of the domain.
  struct Node
  {
    typename FaceLocator<dim>::Query query;
    std::vector<dealii::types::global_dof_index> dofs;
  };
  static std::vector<Node> nodes_of(const InterfaceSide<dim> &side);

  /// An unknown that follows the source.
  struct Follower
  {
    dealii::types::global_dof_index dof;
    unsigned int field, component;
  };
  std::vector<Follower> followers;              ///< that this rank owns
  std::vector<std::vector<double>> transmitted; ///< force on the source, by field and component
  SideRatios ratios;
};

template <int dim>
std::vector<std::string> Pointwise<dim>::notes() const
{
  if (ratios.stiffness > largest_stiffness_of_follower)
    return {words_for_stiff_follower(ratios.stiffness)};
  if (ratios.face_size < 1.1)
    return {};
  std::ostringstream sentence;
  sentence.precision(2);
  sentence
      << "the destination's faces are " << ratios.face_size
      << " times as large as the source's: swap Source and Destination, the pointwise tie is better with the "
         "finer side as destination";
  return {sentence.str()};
}

/// The support points on the side whose unknowns this rank owns.
template <int dim>
std::vector<typename Pointwise<dim>::Node> Pointwise<dim>::nodes_of(const InterfaceSide<dim> &side)
{
  const Domain<dim> &domain = *side.domain;
  const unsigned int n = domain.n_nodes();
  const auto &element = domain.scalar_element();
  const dealii::IndexSet &owned = domain.dof_handler().locally_owned_dofs();
  dealii::FEValues<dim> at_nodes(domain.mapping(), element, element.get_unit_support_points(),
                                 dealii::update_quadrature_points);
  dealii::FEFaceValues<dim> at_face(domain.mapping(), element, dealii::QMidpoint<dim - 1>(),
                                    dealii::update_normal_vectors);
  std::map<dealii::types::global_dof_index, Node> nodes;
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &[cell, face, id] : domain.boundary_faces())
    if (side.belongs(cell, id)) {
      at_nodes.reinit(cell);
      at_face.reinit(cell, face);
      domain.cell_dofs(domain.dof_cell(cell), dofs);
      for (unsigned int a = 0; a < n; ++a)
        if (element.has_support_on_face(a, face) && owned.is_element(dofs[a] - domain.first_dof)) {
          Node &node = nodes[dofs[a]];
          node.query.X = at_nodes.quadrature_point(a) + side.shift;
          node.query.N += at_face.normal_vector(0); // the mean of the faces that meet here
          node.query.face_size = std::max(node.query.face_size, cell->face(face)->diameter());
          node.dofs.clear();
          for (unsigned int c = 0; c < domain.n_components(); ++c)
            node.dofs.push_back(dofs[c * n + a]);
        }
    }
  std::vector<Node> list;
  for (auto &[dof, node] : nodes) {
    node.query.N /= node.query.N.norm();
    list.push_back(node);
  }
  return list;
}

template <int dim>
void Pointwise<dim>::add_constraints(const Interface<dim> &interface, TieConstraints &constraints,
                                     const MPI_Comm &communicator)
{
  ratios = side_ratios(interface, communicator);
  followers.clear();
  transmitted.clear();
  const InterfaceSide<dim> &from = interface.sides[source];
  const FaceLocator<dim> locator = interface.make_locator(source, communicator);
  const std::vector<Node> nodes = nodes_of(interface.sides[destination]);
  std::vector<typename FaceLocator<dim>::Query> queries;
  for (const Node &node : nodes)
    queries.push_back(node.query);
  const auto matches = locator.locate(queries);
  const PartnerShapes<dim> shapes = fetch_shapes(*from.domain, locator, matches, communicator);
  interface.work() += locator.work();

  const unsigned int n = from.domain->n_nodes();
  unsigned int n_followers = 0, n_prescribed = 0;
  for (unsigned int i = 0; i < nodes.size(); ++i) {
    if (!matches[i].found)
      continue;
    const dealii::Tensor<1, dim> gap = nodes[i].query.X - matches[i].X;
    const auto &masters = shapes.cells[shapes.cell_of_point[i]].dofs;
    for (const auto &field : interface.fields)
      for (unsigned int c = 0; c < field.n_components; ++c) {
        const auto dof = nodes[i].dofs[field.first_component[destination] + c];
        ++(constraints.has(dof) ? n_prescribed : n_followers);
        if (constraints.has(dof))
          continue;
        ConstraintLine line;
        for (unsigned int a = 0; a < n; ++a) {
          double weight = shapes.values[i * n + a];
          if (interface.gap_extension() != GapExtension::none)
            weight += shapes.gradients[i * n + a] * gap;
          if (std::abs(weight) > 1e-14)
            line.entries.emplace_back(masters[(field.first_component[source] + c) * n + a], weight);
        }
        if (line.entries.size() == 1 && line.entries[0].first == dof)
          continue; // at the tip of a slit
        constraints.lines.emplace(dof, std::move(line));
        followers.push_back({dof, static_cast<unsigned int>(&field - interface.fields.data()), c});
      }
  }
  n_followers = dealii::Utilities::MPI::sum(n_followers, communicator);
  n_prescribed = dealii::Utilities::MPI::sum(n_prescribed, communicator);
  interface.section.check(
      n_followers > 0 || n_prescribed > 0, "Destination",
      "has no node that faces the source: nothing follows it. Refine the destination, swap Source and "
      "Destination, or use Type = Nitsche.");
  interface.section.check(
      n_followers > 0, "Destination",
      "has unknowns that are prescribed already, all of them, by a boundary condition or by another "
      "interface: nothing is left to follow the source. Swap Source and Destination, or use "
      "Type = Nitsche.");
}

/// What acts on the followers acts on the source.
template <int dim>
void Pointwise<dim>::find_multipliers(const Interface<dim> &interface,
                                      const typename Tie<dim>::Owned & /*solution*/,
                                      const typename Tie<dim>::Owned &force, const MPI_Comm &communicator)
{
  transmitted.clear();
  for (const TiedField &field : interface.fields)
    transmitted.emplace_back(field.n_components, 0.);
  for (const Follower &follower : followers)
    transmitted[follower.field][follower.component] -= force(follower.dof);
  for (std::vector<double> &of_field : transmitted)
    dealii::Utilities::MPI::sum(of_field, communicator, of_field);
}

const bool registered =
    add_tie<Pointwise>("pointwise", "The destination's unknowns follow the source pointwise.");

} // namespace

} // namespace dovetail
