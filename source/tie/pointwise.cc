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

template <int dim>
class Pointwise : public Tie<dim>, public Elimination<dim>, public FluxRecovery<dim>
{
public:
  explicit Pointwise(const Section &) {}

  TieParts<dim> parts() override { return {nullptr, this, nullptr, this}; }
  std::array<bool, 2> integrates_on() const override { return {{false, true}}; }
  bool has_constant_tangent(const Interface<dim> &) const override { return true; }
  std::string description() const override { return "the destination's unknowns follow the source"; }
  void add_constraints(const Interface<dim> &interface, TieConstraints &constraints,
                       const MPI_Comm &communicator) override;
  std::vector<std::string> notes() const override;

  void find_multipliers(const Interface<dim> &interface, const ValueAt &solution, const ValueAt &force,
                        const MPI_Comm &communicator) override;
  std::vector<Transmission> transmissions() const override { return transmitted; }
  const std::vector<HeldUnknown> &held() const override { return prescribed; }

private:
  /// A support point of the destination and its unknowns, one per component of the domain.
  struct Node
  {
    typename FaceLocator<dim>::Query query;
    std::vector<dealii::types::global_dof_index> dofs;
    /// Cells with faces on the side, and the node's number there.
    std::vector<std::pair<typename dealii::Triangulation<dim>::active_cell_iterator, unsigned int>> cells;
  };
  static std::vector<Node> nodes_of(const InterfaceSide<dim> &side);
  static bool crosses_edges(const Pairing<dim> &pairing, const MPI_Comm &communicator);
  /// From the source to a node: the gap, for each field the share of it that the node's side bridges, and the
  /// source's unknowns and shapes there.
  struct Bridge
  {
    dealii::Point<dim> X; ///< of the source
    dealii::Tensor<1, dim> gap;
    std::vector<double> own_share;
    const std::vector<dealii::types::global_dof_index> *masters;
    unsigned int n_masters; ///< of a component
    const double *values;
    const dealii::Tensor<1, dim> *gradients;
  };
  static Bridge find_bridge(const Interface<dim> &interface, const Node &node,
                            const typename FaceLocator<dim>::Match &match, const PartnerShapes<dim> &shapes,
                            unsigned int point);
  static GapConstraint follow(const Interface<dim> &interface, const TiedField &field, unsigned int c,
                              const Bridge &bridge, double t);
  static void add_own_gradient(const Domain<dim> &domain, const Node &node, unsigned int component,
                               const dealii::Tensor<1, dim> &direction,
                               const dealii::AffineConstraints<double> &hanging, ShapeEvaluator<dim> &shapes,
                               std::map<dealii::types::global_dof_index, double> &entries);
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
std::vector<std::string> Pointwise<dim>::notes() const
{
  if (ratios.stiffness > largest_stiffness_ratio)
    return {note_on_stiff_destination(ratios.stiffness)};
  if (ratios.face_size < 1.1) {
    if (lost_degree < 2)
      return {};
    return {"the destination's faces of degree " + std::to_string(lost_degree) +
            " lie across edges of the source's, where its trace has kinks that they cannot follow: the tie "
            "errs as with degree 1. Use Type = Nitsche or mortar"};
  }
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
          node.cells.emplace_back(cell, a);
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
  const unsigned int n = domain.n_nodes();
  std::vector<double> values(n);
  std::vector<dealii::Tensor<1, dim>> gradients(n);
  std::vector<dealii::types::global_dof_index> dofs;
  for (const auto &[cell, own] : node.cells) {
    shapes.reinit(cell);
    shapes.evaluate(domain.scalar_element().unit_support_point(own), values.data(), gradients.data());
    domain.cell_dofs(domain.dof_cell(cell), dofs);
    for (unsigned int a = 0; a < n; ++a) {
      const double weight = gradients[a] * direction / node.cells.size();
      if (std::abs(weight) <= 1e-14)
        continue;
      const auto dof = dofs[component * n + a];
      if (hanging.is_constrained(dof - domain.first_dof))
        for (const auto &[master, master_weight] : *hanging.get_constraint_entries(dof - domain.first_dof))
          entries[domain.first_dof + master] += weight * master_weight;
      else
        entries[dof] += weight;
    }
  }
}

template <int dim>
typename Pointwise<dim>::Bridge Pointwise<dim>::find_bridge(const Interface<dim> &interface, const Node &node,
                                                            const typename FaceLocator<dim>::Match &match,
                                                            const PartnerShapes<dim> &shapes,
                                                            const unsigned int point)
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
  const unsigned int n = interface.sides[source].domain->n_nodes();
  bridge.masters = &shapes.cells[shapes.cell_of_point[point]].dofs;
  bridge.n_masters = n;
  bridge.values = &shapes.values[point * n];
  bridge.gradients = &shapes.gradients[point * n];
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
  for (unsigned int a = 0; a < bridge.n_masters; ++a) {
    const auto master = (*bridge.masters)[(field.first_component[source] + c) * bridge.n_masters + a];
    const double value = bridge.values[a], extension = bridge.gradients[a] * bridge.gap;
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
  const InterfaceSide<dim> &from = interface.sides[source], &to = interface.sides[destination];
  const FaceLocator<dim> locator = interface.make_locator(source, communicator);
  const std::vector<Node> nodes = nodes_of(to);
  std::vector<typename FaceLocator<dim>::Query> queries;
  for (const Node &node : nodes)
    queries.push_back(node.query);
  const auto matches = locator.locate(queries);
  const PartnerShapes<dim> shapes = fetch_shapes(*from.domain, locator, matches, communicator);
  interface.work() += locator.work();

  std::map<dealii::types::global_dof_index, GapConstraint> constrained;
  const auto hanging = to.domain->hanging_nodes();
  ShapeEvaluator<dim> own_shapes(*to.domain);
  unsigned int n_constrained = 0, n_prescribed = 0;
  for (unsigned int i = 0; i < nodes.size(); ++i) {
    if (!matches[i].found)
      continue;
    const Bridge bridge = find_bridge(interface, nodes[i], matches[i], shapes, i);
    for (unsigned int f = 0; f < interface.fields.size(); ++f)
      for (unsigned int c = 0; c < interface.fields[f].n_components; ++c) {
        const unsigned int component = interface.fields[f].first_component[destination] + c;
        const auto dof = nodes[i].dofs[component];
        ++(constraints.has(dof) ? n_prescribed : n_constrained);
        if (constraints.has(dof)) {
          hold(dof, f, c, interface.fields[f], bridge, constraints);
          continue;
        }
        GapConstraint constraint = follow(interface, interface.fields[f], c, bridge, constraints.t);
        if (constraint.first.from_source.size() == 1 && constraint.first.from_source.count(dof) > 0)
          continue; // at the tip of a slit
        if (bridge.own_share[f] > 0)
          add_own_gradient(*to.domain, nodes[i], component, bridge.own_share[f] * bridge.gap, hanging,
                           own_shapes, constraint.wanted.from_destination);
        constrained[dof] = std::move(constraint);
        places[dof] = {f, c, {{-1., 1.}}};
      }
  }
  for (const auto &[dof, line] :
       gap_constraints(constrained, *to.domain, constraints, communicator, interface.work())) {
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
  for (unsigned int a = 0; a < bridge.n_masters; ++a)
    if (std::abs(bridge.values[a]) > 1e-14)
      unknown.source.emplace_back(
          (*bridge.masters)[(field.first_component[source] + c) * bridge.n_masters + a], bridge.values[a]);
  prescribed.push_back(std::move(unknown));
}

/// What acts on the constrained acts on the source.
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
