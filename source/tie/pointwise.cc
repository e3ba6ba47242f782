// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Pointwise continuity at the support points X of the destination side, through the map to the source side:
//
//     B_dst(X) = B_src(X') + grad B_src(X').(X - X') = sum_a (phi_a(X') + grad phi_a(X').(X - X')) B_a
//
// (the second term only over a gap, of which the gradient of a stiffer destination bridges its share,
// side_ratios.h), as constraints that are condensed out of the system. It passes the patch
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
#include <dovetail/pairing/partner_shapes.h>
#include <dovetail/tie/gap_constraints.h>

#include <deal.II/base/mpi.h>
#include <deal.II/dofs/dof_tools.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace dovetail {

namespace {

const NoteName of_kinks("kinks", "a pointwise tie of degree two or more errs as one of degree one");
const NoteName of_coarse_destination("coarse destination",
                                     "the destination of a pointwise tie is the coarser side");

template <int dim>
class Pointwise : public Tie<dim>, public Elimination<dim>, public FluxRecovery<dim>
{
public:
  explicit Pointwise(const Section &) {}

  TieParts<dim> parts() override { return {nullptr, this, nullptr, this}; }
  std::array<bool, 2> integrates_on() const override { return {{false, true}}; }
  std::string type_for_errors() const override { return "Nitsche"; }
  bool has_constant_tangent(const Interface<dim> &) const override { return true; }
  std::string description() const override { return "the destination's unknowns follow the source"; }
  void add_constraints(const Interface<dim> &interface, TieConstraints &constraints,
                       const MPI_Comm &communicator) override;
  NoteList notes() const override;

  void find_multipliers(const Interface<dim> &interface, const ValueAt &solution, const ValueAt &force,
                        const MPI_Comm &communicator) override;
  std::vector<Transmission> transmissions() const override { return transmitted; }
  const std::vector<HeldUnknown> &held() const override { return prescribed; }

private:
  /// A support point of a space of the destination and the unknowns of the components of that space.
  struct Node
  {
    typename FaceLocator<dim>::Query query;
    std::map<unsigned int, dealii::types::global_dof_index> dofs; ///< by component
    /// Cells with faces on the side, and the node's number there.
    std::vector<std::pair<typename dealii::Triangulation<dim>::active_cell_iterator, unsigned int>> cells;
  };
  static std::vector<Node> nodes_of(const InterfaceSide<dim> &side, unsigned int space);
  static bool crosses_edges(const Pairing<dim> &pairing, const MPI_Comm &communicator);
  /// From the source to a node: the gap, for each field the share of it that the node's side bridges, and the
  /// source's unknowns and shapes there.
  struct Bridge
  {
    dealii::Point<dim> X; ///< of the source
    dealii::Tensor<1, dim> gap;
    std::vector<double> own_share;
    const std::vector<dealii::types::global_dof_index> *masters;
    const CellLayout<dim> *layout; ///< of the source
    std::vector<double> values;    ///< of all its shape functions
    std::vector<dealii::Tensor<1, dim>> gradients;
  };
  static Bridge find_bridge(const Interface<dim> &interface, const Node &node,
                            const typename FaceLocator<dim>::Match &match, const PartnerShapes<dim> &partners,
                            unsigned int point, UnitShapes<dim> &shapes);
  static GapConstraint follow(const Interface<dim> &interface, const TiedField &field, unsigned int c,
                              const Bridge &bridge, double t);
  static void add_own_gradient(const Domain<dim> &domain, const Node &node, unsigned int component,
                               const dealii::Tensor<1, dim> &direction,
                               const dealii::AffineConstraints<double> &hanging, ShapeEvaluator<dim> &shapes,
                               std::map<dealii::types::global_dof_index, double> &entries);
  using Followers = std::map<dealii::types::global_dof_index, GapConstraint>;
  std::array<unsigned int, 2> add_followers(const Interface<dim> &interface, unsigned int space,
                                            const FaceLocator<dim> &locator,
                                            const TieConstraints &constraints, const MPI_Comm &communicator,
                                            Followers &constrained);
  void hold(dealii::types::global_dof_index dof, unsigned int f, unsigned int c, const TiedField &field,
            const Bridge &bridge, const TieConstraints &constraints);

  /// An unknown that follows the source.
  struct Place
  {
    unsigned int field, component;
    std::array<double, 2> shares; ///< of its force, that its line gives to the sides
  };
  std::map<dealii::types::global_dof_index, Place> places; ///< of those that this rank owns
  std::vector<HeldUnknown> prescribed;
  std::vector<Transmission> transmitted;
  SideRatios ratios;
  unsigned int lost_degree =
      0; ///< that of a destination which follows across edges of faces of the source; or 0
};

template <int dim>
NoteList Pointwise<dim>::notes() const
{
  if (ratios.stiffness > largest_stiffness_ratio)
    return {note_on_stiff_destination(ratios.stiffness)};
  if (ratios.face_size < 1.1) {
    if (lost_degree < 2)
      return {};
    return {of_kinks(
        "the destination's faces of degree " + std::to_string(lost_degree) +
        " lie across edges of the source's, where its trace has kinks that they cannot follow: the tie "
        "errs as with degree 1. Use Type = Nitsche or mortar")};
  }
  std::ostringstream sentence;
  sentence.precision(2);
  sentence
      << "the destination's faces are " << ratios.face_size
      << " times as large as the source's: swap Source and Destination, the pointwise tie is better with the "
         "finer side as destination";
  return {of_coarse_destination(sentence.str())};
}

/// The support points on the side whose unknowns this rank owns.
template <int dim>
std::vector<typename Pointwise<dim>::Node> Pointwise<dim>::nodes_of(const InterfaceSide<dim> &side,
                                                                    const unsigned int space)
{
  const Domain<dim> &domain = *side.domain;
  const CellLayout<dim> &layout = domain.layout();
  const auto &element = layout.element_of_space(space);
  std::vector<unsigned int> components;
  for (unsigned int c = 0; c < layout.n_components(); ++c)
    if (layout.space(c) == space)
      components.push_back(c);
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
      for (unsigned int a = 0; a < element.n_dofs_per_cell(); ++a)
        if (const auto first = dofs[layout.index(components[0], a)];
            element.has_support_on_face(a, face) && owned.is_element(first - domain.first_dof())) {
          Node &node = nodes[first];
          node.query.X = at_nodes.quadrature_point(a) + side.shift;
          node.query.N += at_face.normal_vector(0); // the mean of the faces that meet here
          node.query.face_size = std::max(node.query.face_size, cell->face(face)->diameter());
          node.cells.emplace_back(cell, a);
          for (const unsigned int c : components)
            node.dofs[c] = dofs[layout.index(c, a)];
        }
    }
  std::vector<Node> list;
  for (auto &[dof, node] : nodes) {
    node.query.N /= node.query.N.norm();
    list.push_back(node);
  }
  return list;
}

/// Whether a face of the destination faces several of the source.
template <int dim>
bool Pointwise<dim>::crosses_edges(const Pairing<dim> &pairing, const MPI_Comm &communicator)
{
  const double sliver = 1e-3; // coordinates of files have six or seven digits
  std::vector<unsigned int> n_partners(pairing.cells[destination].size(), 0);
  for (const auto &group : pairing.groups) {
    double area = 0;
    for (unsigned int q = group.begin; q < group.end; ++q)
      area += pairing.weight(q);
    const unsigned int face = group.cells[destination];
    n_partners[face] += area > sliver * pairing.cells[destination][face].face_measure ? 1 : 0;
  }
  const bool does = std::any_of(n_partners.begin(), n_partners.end(), [](const auto n) { return n > 1; });
  return dealii::Utilities::MPI::max(does ? 1 : 0, communicator) == 1;
}

/// Add the derivative of a component along a direction at a node, the mean of its cells'.
template <int dim>
void Pointwise<dim>::add_own_gradient(const Domain<dim> &domain, const Node &node,
                                      const unsigned int component, const dealii::Tensor<1, dim> &direction,
                                      const dealii::AffineConstraints<double> &hanging,
                                      ShapeEvaluator<dim> &shapes,
                                      std::map<dealii::types::global_dof_index, double> &entries)
{
  const CellLayout<dim> &layout = domain.layout();
  std::vector<double> values(layout.n_shapes());
  std::vector<dealii::Tensor<1, dim>> gradients(layout.n_shapes());
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &[cell, own] : node.cells) {
    shapes.reinit(cell);
    shapes.evaluate(layout.element(component).unit_support_point(own), values.data(), gradients.data());
    domain.cell_dofs(domain.dof_cell(cell), dofs);
    for (unsigned int a = 0; a < layout.n_nodes(component); ++a) {
      const double weight = gradients[layout.first_shape(component) + a] * direction / node.cells.size();
      if (std::abs(weight) <= 1e-14)
        continue;
      const auto dof = dofs[layout.index(component, a)];
      if (hanging.is_constrained(dof - domain.first_dof()))
        for (const auto &[master, master_weight] : *hanging.get_constraint_entries(dof - domain.first_dof()))
          entries[domain.first_dof() + master] += weight * master_weight;
      else
        entries[dof] += weight;
    }
  }
}

template <int dim>
typename Pointwise<dim>::Bridge Pointwise<dim>::find_bridge(const Interface<dim> &interface, const Node &node,
                                                            const typename FaceLocator<dim>::Match &match,
                                                            const PartnerShapes<dim> &partners,
                                                            const unsigned int point, UnitShapes<dim> &shapes)
{
  const std::array<dealii::Point<dim>, 2> X = {
      {match.X - interface.sides[source].shift, node.query.X - interface.sides[destination].shift}};
  Bridge bridge;
  bridge.X = X[source];
  if (interface.gap_extension() != GapExtension::none)
    bridge.gap = node.query.X - match.X;
  for (const TiedField &field : interface.fields)
    bridge.own_share.push_back(bridge.gap.norm() > 1e-13 * node.query.face_size
                                   ? own_share_of_gap(interface, field, destination, X)
                                   : 0);
  bridge.layout = &interface.sides[source].domain->layout();
  const unsigned int n = bridge.layout->n_shapes();
  bridge.masters = &partners.cells[partners.cell_of_point[point]].dofs;
  bridge.values.resize(n);
  bridge.gradients.resize(n);
  shapes.evaluate(match.unit_point, partners.inverse_jacobians[point], bridge.values.data(),
                  bridge.gradients.data());
  return bridge;
}

/// What component c of a field takes from the source.
template <int dim>
GapConstraint Pointwise<dim>::follow(const Interface<dim> &interface, const TiedField &field,
                                     const unsigned int c, const Bridge &bridge, const double t)
{
  const double own_share = bridge.own_share[field.index];
  GapConstraint constraint;
  if (interface.has_prescribed_jump())
    constraint.first.offset = constraint.wanted.offset = -interface.prescribed_jump(bridge.X, t, c);
  for (unsigned int a = 0; a < field.n_nodes[source]; ++a) {
    const auto master = (*bridge.masters)[bridge.layout->index(field.first_component[source] + c, a)];
    const unsigned int s = field.first_shape[source] + a;
    const double value = bridge.values[s], extension = bridge.gradients[s] * bridge.gap;
    if (std::abs(value + extension) > 1e-14)
      constraint.first.from_source[master] += value + extension;
    if (std::abs(value + (1 - own_share) * extension) > 1e-14)
      constraint.wanted.from_source[master] += value + (1 - own_share) * extension;
  }
  return constraint;
}

template <int dim>
void Pointwise<dim>::add_constraints(const Interface<dim> &interface, TieConstraints &constraints,
                                     const MPI_Comm &communicator)
{
  ratios = side_ratios(interface, communicator);
  lost_degree =
      crosses_edges(interface.pairing(), communicator) ? interface.sides[destination].domain->degree : 0;
  places.clear();
  prescribed.clear();
  transmitted.clear();
  const Domain<dim> &to = *interface.sides[destination].domain;
  std::set<unsigned int> spaces;
  for (const TiedField &field : interface.fields)
    spaces.insert(to.layout().space(field.first_component[destination]));
  const FaceLocator<dim> locator = interface.make_locator(source, communicator);
  Followers constrained;
  unsigned int n_constrained = 0, n_prescribed = 0;
  for (const unsigned int space : spaces) {
    const auto counts = add_followers(interface, space, locator, constraints, communicator, constrained);
    n_constrained += counts[0];
    n_prescribed += counts[1];
  }
  interface.work() += locator.work();
  for (const auto &[dof, line] :
       gap_constraints(constrained, to, constraints, communicator, interface.work())) {
    places.at(dof).shares = {{-line.source_weight(), 1 - line.destination_weight()}};
    constraints.add(dof, line.as_constraint());
  }
  n_constrained = dealii::Utilities::MPI::sum(n_constrained, communicator);
  n_prescribed = dealii::Utilities::MPI::sum(n_prescribed, communicator);
  interface.section.check(
      n_constrained > 0 || n_prescribed > 0, "Destination",
      "has no node that faces the source: nothing follows it. Refine the destination, swap Source and "
      "Destination, or use Type = Nitsche.");
  interface.section.check(
      n_constrained > 0, "Destination",
      "has unknowns that are prescribed already, all of them, by a boundary condition or by another "
      "interface: nothing is left to follow the source. Swap Source and Destination, or use "
      "Type = Nitsche.");
}

/// Of the nodes of a space of the destination. @return their numbers: of unknowns that may follow, and of
/// those that have a line already.
template <int dim>
std::array<unsigned int, 2>
Pointwise<dim>::add_followers(const Interface<dim> &interface, const unsigned int space,
                              const FaceLocator<dim> &locator, const TieConstraints &constraints,
                              const MPI_Comm &communicator, Followers &constrained)
{
  const InterfaceSide<dim> &to = interface.sides[destination];
  const std::vector<Node> nodes = nodes_of(to, space);
  std::vector<typename FaceLocator<dim>::Query> queries;
  for (const Node &node : nodes)
    queries.push_back(node.query);
  const auto matches = locator.locate(queries);
  const PartnerShapes<dim> partners =
      fetch_shapes(*interface.sides[source].domain, locator, matches, false, communicator);
  const auto hanging = to.domain->hanging_nodes();
  ShapeEvaluator<dim> own_shapes(*to.domain);
  UnitShapes<dim> source_shapes(*interface.sides[source].domain);
  std::array<unsigned int, 2> n = {{0, 0}};
  for (unsigned int i = 0; i < nodes.size(); ++i) {
    if (!matches[i].found)
      continue;
    const Bridge bridge = find_bridge(interface, nodes[i], matches[i], partners, i, source_shapes);
    for (const TiedField &field : interface.fields)
      for (unsigned int c = 0; c < field.n_components; ++c) {
        const unsigned int component = field.first_component[destination] + c;
        if (nodes[i].dofs.count(component) == 0)
          continue;
        const auto dof = nodes[i].dofs.at(component);
        ++n[constraints.has(dof) ? 1 : 0];
        if (constraints.has(dof)) {
          hold(dof, field.index, c, field, bridge, constraints);
          continue;
        }
        GapConstraint constraint = follow(interface, field, c, bridge, constraints.t);
        if (constraint.first.from_source.size() == 1 && constraint.first.from_source.count(dof) > 0)
          continue; // at the tip of a slit
        if (bridge.own_share[field.index] > 0)
          add_own_gradient(*to.domain, nodes[i], component, bridge.own_share[field.index] * bridge.gap,
                           hanging, own_shapes, constraint.wanted.from_destination);
        constrained[dof] = std::move(constraint);
        places[dof] = {field.index, c, {{-1., 1.}}};
      }
  }
  return n;
}

/// An unknown that has a line already, if it is a prescribed one.
template <int dim>
void Pointwise<dim>::hold(const dealii::types::global_dof_index dof, const unsigned int f,
                          const unsigned int c, const TiedField &field, const Bridge &bridge,
                          const TieConstraints &constraints)
{
  const auto known = constraints.lines.find(dof);
  if (known == constraints.lines.end() || !known->second.entries.empty())
    return;
  HeldUnknown unknown = {dof, f, c, {}};
  for (unsigned int a = 0; a < field.n_nodes[source]; ++a)
    if (const double value = bridge.values[field.first_shape[source] + a]; std::abs(value) > 1e-14)
      unknown.source.emplace_back(
          (*bridge.masters)[bridge.layout->index(field.first_component[source] + c, a)], value);
  prescribed.push_back(std::move(unknown));
}

/// What acts on the constrained unknowns acts on the source.
template <int dim>
void Pointwise<dim>::find_multipliers(const Interface<dim> & /*interface*/, const ValueAt & /*solution*/,
                                      const ValueAt &force, const MPI_Comm & /*communicator*/)
{
  transmitted.clear();
  for (const auto &[dof, place] : places)
    transmitted.push_back({place.field,
                           place.component,
                           {{place.shares[source] * force(dof), place.shares[destination] * force(dof)}}});
}

const bool registered =
    add_tie<Pointwise>("pointwise", "The destination's unknowns follow the source pointwise.");

} // namespace

} // namespace dovetail
