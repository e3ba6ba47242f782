// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Continuity in the mean: the jump is orthogonal to a space of multipliers lambda = sum_j lambda_j psi_j on
// the destination (Bernardi, Maday & Patera 1994; Wohlmuth 2000), which are the influx into the source:
//
//     R(delta) = int_Gamma  - lambda.delta[B] - mu.[B]  dGamma      [B] = B_src - map(B_dst)
//
// dual: each equation int psi_j [B] = 0 holds one destination unknown and becomes its constraint, so that the
// system has no further unknowns and stays symmetric and positive definite. lambda_j is what the constraint
// transmits divided by int psi_j phi_j.
//
// standard: the lambda_j are unknowns. With g_j = int psi_j (B_dst - B_src) the terms are those of the
// augmented Lagrangian
//
//     sum_j  lambda_j g_j + 1/2 w_j g_j^2,     w_j = gamma_j / int psi_j phi_j,
//
// with gamma the penalty of Nitsche's method (trace_eigenvalue.h), averaged over the function. g_j vanishes
// at the solution, so w_j does not change it; but it makes the block of the domains positive definite and the
// Schur complement of the multipliers spectrally equivalent to 1/w_j (Benzi, Golub & Liesen 2005), whatever
// the mesh size and the contrast, on which the preconditioner relies.
//
//     subsection Interface seam
//       set Type             = mortar
//       set Source           = left : 1
//       set Destination      = right : 0
//       set Multiplier space = dual
//     end

#include <dovetail/interface/side_ratios.h>
#include <dovetail/tie/gap_constraints.h>
#include <dovetail/tie/multiplier_space.h>
#include <dovetail/tie/penalty.h>

#include <deal.II/base/mpi.h>

#include <cmath>
#include <numeric>

namespace dovetail {

namespace {

const NoteName of_order("multiplier space", "multipliers are of a lower order than the displacements");
const NoteName of_multipliers("multipliers", "some unknowns of a destination have no multipliers");

template <int dim>
class Mortar : public Tie<dim>, public Elimination<dim>, public Multipliers<dim>, public FluxRecovery<dim>
{
public:
  using Index = dealii::types::global_dof_index;

  explicit Mortar(const Section &section);

  TieParts<dim> parts() override { return {nullptr, this, this, this}; }
  std::array<bool, 2> integrates_on() const override { return {{false, true}}; }
  bool asks_bridges() const override { return true; }
  bool has_constant_tangent(const Interface<dim> &interface) const override
  {
    return is_dual || interface.has_constant_fluxes();
  }
  std::string description() const override
  {
    return is_dual ? "dual multipliers, condensed" : "standard multipliers, unknowns of their own";
  }
  void add_constraints(const Interface<dim> &interface, TieConstraints &constraints,
                       const MPI_Comm &communicator) override;
  void begin_step(const Interface<dim> &interface, double t, const ValuesOf &unknowns,
                  const MPI_Comm &communicator) override;
  bool update_penalties(const Interface<dim> &interface, double t, const ValuesOf &unknowns,
                        const MPI_Comm &communicator) override;

  std::vector<Index> unknowns_with_multiplier(const Interface<dim> &interface,
                                              const TiedField &field) const override;
  unsigned int n_terms() const override { return terms.size(); }
  const std::vector<Index> &term_dofs(const unsigned int term) const override { return terms[term].dofs; }
  void assemble_term(unsigned int term, const std::vector<double> &unknowns, std::vector<double> &residual,
                     dealii::FullMatrix<double> *tangent) const override;

  double magnitude_of_term(unsigned int term, const std::vector<double> &unknowns) const override;

  void find_multipliers(const Interface<dim> &interface, const ValueAt &solution, const ValueAt &force,
                        const MPI_Comm &communicator) override;
  std::vector<Transmission> transmissions() const override { return transmitted; }
  void numerical_flux(const Interface<dim> &interface, const TiedField &field, unsigned int q,
                      const std::array<State<dim>, 2> &state, const std::array<std::vector<double>, 2> &flux,
                      const std::vector<double> &jump, std::vector<double> &result) const override;
  NoteList notes() const override;

private:
  /// A multiplier with its unknowns, or alone and zero.
  struct Term
  {
    std::vector<Index> dofs;
    std::vector<double> weights; ///< of all but the last
    double constant = 0;         ///< of a prescribed jump
    double augmentation = 0;     ///< w_j
    Index node = 0;              ///< the destination unknown it belongs to

    /// Of the multiplier's equation.
    double g(const std::vector<double> &unknowns) const
    {
      return std::inner_product(weights.begin(), weights.end(), unknowns.begin(), constant);
    }
  };

  std::vector<Index> owned_nodes(const Interface<dim> &interface, const TiedField &field) const;
  void add_lines(const Interface<dim> &interface, TieConstraints &constraints, const MPI_Comm &communicator);
  void make_terms(const Interface<dim> &interface, std::set<Index> &multiplied);
  std::vector<std::vector<double>> penalties(const Interface<dim> &interface, double t,
                                             const ValuesOf &unknowns, const MPI_Comm &communicator) const;
  std::vector<double> augmentations(const Interface<dim> &interface, double t, const ValuesOf &unknowns,
                                    const MPI_Comm &communicator) const;

  /// The share of an unknown's force that acts on the source, if the destination's gradient bridges a gap.
  double source_share(const Index dof) const
  {
    const auto found = source_shares.find(dof);
    return found == source_shares.end() ? 1 : found->second;
  }

  const bool is_dual;
  bool loses_order = false; ///< dual functions on nodes that are not those of Gauss and Lobatto
  std::unique_ptr<MultiplierSpace<dim>> space;
  std::map<Index, double> source_shares;
  std::map<Index, std::array<double, 2>> shares_of_force; ///< that a constrained unknown gives to the sides
  std::vector<Term> terms;
  std::vector<Transmission> transmitted;
  SideRatios ratios;
  bool has_begun = false;
};

template <int dim>
Mortar<dim>::Mortar(const Section &section)
    : is_dual(section.choose("Multiplier space", {"dual", "standard"}, 0,
                             "dual: multipliers that are biorthogonal to the destination's shape functions, "
                             "condensed into constraints; standard: the traces of the destination's shape "
                             "functions, whose coefficients are additional unknowns [-]") == 0)
{
}

/// The unknowns of a field on the destination's faces that this rank owns.
template <int dim>
std::vector<dealii::types::global_dof_index> Mortar<dim>::owned_nodes(const Interface<dim> &interface,
                                                                      const TiedField &field) const
{
  const InterfaceSide<dim> &side = interface.sides[destination];
  const Domain<dim> &domain = *side.domain;
  const dealii::IndexSet &owned = domain.dof_handler().locally_owned_dofs();
  const auto &element = domain.layout().element(field.first_component[destination]);
  std::set<Index> nodes;
  std::vector<Index> dofs;
  for (const auto &[cell, face, id] : domain.boundary_faces())
    if (side.belongs(cell, id)) {
      domain.cell_dofs(domain.dof_cell(cell), dofs);
      for (unsigned int c = 0; c < field.n_components; ++c)
        for (unsigned int a = 0; a < field.n_nodes[destination]; ++a)
          if (const Index dof = dofs[domain.layout().index(field.first_component[destination] + c, a)];
              element.has_support_on_face(a, face) && owned.is_element(dof - domain.first_dof()))
            nodes.insert(dof);
    }
  return {nodes.begin(), nodes.end()};
}

template <int dim>
std::vector<dealii::types::global_dof_index>
Mortar<dim>::unknowns_with_multiplier(const Interface<dim> &interface, const TiedField &field) const
{
  return is_dual ? std::vector<Index>() : owned_nodes(interface, field);
}

template <int dim>
void Mortar<dim>::add_constraints(const Interface<dim> &interface, TieConstraints &constraints,
                                  const MPI_Comm &communicator)
{
  const Domain<dim> &domain = *interface.sides[destination].domain;
  unsigned int degree = 0; // of the tied fields
  for (const TiedField &field : interface.fields)
    degree = std::max(degree, domain.layout().element(field.first_component[destination]).degree);
  interface.section.check(!is_dual || dim == 2 || degree == 1 || !domain.has_simplices(), "Multiplier space",
                          "cannot be dual on tetrahedra of degree 2: the shape functions of the corners have "
                          "the integral zero over a "
                          "face, so no biorthogonal function exists. Set Multiplier space = standard, swap "
                          "Source and Destination, or "
                          "use Type = Nitsche.");
  loses_order = is_dual && domain.has_simplices() && degree > 2;
  ratios = side_ratios(interface, communicator);
  space = std::make_unique<MultiplierSpace<dim>>(interface, is_dual);
  space->make(constraints, communicator);
  interface.section.check(space->n_rows > 0 || space->n_hardly_covered == 0, "Destination",
                          "has no face that the source covers to a large part, so no multiplier is left. "
                          "Refine the destination, swap "
                          "Source and Destination, or use Type = Nitsche.");
  interface.section.check(
      space->n_rows > 0, "Destination",
      "has unknowns that are prescribed already, all of them, by a boundary condition or by another "
      "interface: no multiplier is left. Swap Source and Destination, or use Type = Nitsche.");
  has_begun = false;
  if (is_dual)
    add_lines(interface, constraints, communicator);
  else
    make_terms(interface, constraints.multiplied);
  for (auto &[dof, row] : space->rows) { // which lines or terms have now
    row.weights.clear();
    row.own_gradient.clear();
    row.source_gain.clear();
    row.of_source.clear();
  }
}

template <int dim>
void Mortar<dim>::add_lines(const Interface<dim> &interface, TieConstraints &constraints,
                            const MPI_Comm &communicator)
{
  const Domain<dim> &to = *interface.sides[destination].domain;
  const bool is_of_both = interface.sides[source].domain == &to;
  std::map<Index, GapConstraint> constrained;
  std::map<Index, double> own_of_source; // the part of an unknown's own weight, where the source has it, too
  for (const auto &[dof, row] : space->rows) {
    const auto find = [](const std::map<Index, double> &weights, const Index other) {
      const auto found = weights.find(other);
      return found == weights.end() ? 0. : found->second;
    };
    // differs from the diagonal where the source has the same unknown
    const double own = find(row.weights, dof) - find(row.own_gradient, dof);
    if (std::abs(own) < 1e-10 * row.diagonal)
      continue;
    GapConstraint &constraint = constrained[dof];
    const auto add = [own](std::map<Index, double> &part, const Index other, const double weight) {
      part[other] -= weight / own;
    };
    for (const auto &[other, weight] : row.weights) {
      const bool is_of_body = other >= to.first_dof() && other < to.first_dof() + to.dof_handler().n_dofs();
      const double of_source = is_of_both ? find(row.of_source, other) : is_of_body ? 0. : weight;
      if (other == dof && of_source != 0)
        own_of_source[dof] = of_source / own;
      if (other != dof && of_source != 0)
        add(constraint.first.from_source, other, of_source);
      if (other != dof && of_source != weight)
        add(constraint.first.from_destination, other, weight - of_source);
    }
    constraint.first.offset = -row.constant / own;
    if (row.own_gradient.empty())
      continue;
    constraint.wanted = constraint.first;
    add(constraint.wanted.from_destination, dof, find(row.own_gradient, dof));
    for (const auto &[other, weight] : row.own_gradient)
      if (other != dof)
        add(constraint.first.from_destination, other, -weight);
    for (const auto &[other, weight] : row.source_gain)
      add(constraint.first.from_source, other, weight);
    auto &entries = constraint.first.from_destination;
    for (auto entry = entries.begin(); entry != entries.end();)
      entry = std::abs(entry->second) <= 1e-14 ? entries.erase(entry) : std::next(entry);
  }
  source_shares.clear();
  shares_of_force.clear();
  for (const auto &[dof, line] :
       gap_constraints(constrained, to, constraints, communicator, interface.work())) {
    constraints.add(dof, line.as_constraint());
    const auto own = own_of_source.find(dof);
    const double both = own == own_of_source.end() ? 0. : own->second;
    shares_of_force[dof] = {{both - line.source_weight(), 1 - line.destination_weight() - both}};
    if (const GapConstraint &constraint = constrained.at(dof); !constraint.wanted.from_destination.empty())
      source_shares[dof] = line.source_weight() / constraint.first.source_weight();
  }
}

template <int dim>
void Mortar<dim>::make_terms(const Interface<dim> &interface, std::set<Index> &multiplied)
{
  terms.clear();
  for (const TiedField &field : interface.fields) {
    Index multiplier = field.first_multiplier;
    for (const Index node : owned_nodes(interface, field)) {
      Term term;
      term.node = node;
      if (const auto row = space->rows.find(node); row != space->rows.end()) {
        multiplied.insert(node);
        term.constant = row->second.constant;
        for (const auto &[dof, weight] : row->second.weights) {
          term.dofs.push_back(dof);
          term.weights.push_back(weight);
        }
      }
      term.dofs.push_back(multiplier++);
      terms.push_back(std::move(term));
    }
  }
}

/// The penalty of Nitsche's method with a = 1, per field and point.
template <int dim>
std::vector<std::vector<double>> Mortar<dim>::penalties(const Interface<dim> &interface, const double t,
                                                        const ValuesOf &unknowns,
                                                        const MPI_Comm &communicator) const
{
  const Pairing<dim> &pairing = interface.pairing();
  std::vector<std::vector<double>> gamma;
  for (const TiedField &field : interface.fields) {
    const auto lambda = trace_eigenvalues(interface, field, t, unknowns, communicator).penalty_values;
    gamma.emplace_back(pairing.n_points());
    for (const auto &group : pairing.groups) {
      const double one = lambda[source][group.cells[source]],
                   other = lambda[destination][group.cells[destination]];
      for (unsigned int q = group.begin; q < group.end; ++q)
        gamma.back()[q] = one + other > 0 ? eigenvalue_penalty(one, other) : 0;
    }
  }
  return gamma;
}

/// w_j of each term.
template <int dim>
std::vector<double> Mortar<dim>::augmentations(const Interface<dim> &interface, const double t,
                                               const ValuesOf &unknowns, const MPI_Comm &communicator) const
{
  const auto gamma = space->average(penalties(interface, t, unknowns, communicator), communicator);
  std::vector<double> result;
  for (const Term &term : terms) {
    const double w = term.weights.empty() ? 0. : gamma.at(term.node) / space->rows.at(term.node).diagonal;
    // where the tangent has lost its positivity the last one is kept
    result.push_back(w >= 0 && std::isfinite(w) ? w : term.augmentation);
  }
  return result;
}

template <int dim>
void Mortar<dim>::begin_step(const Interface<dim> &interface, const double t, const ValuesOf &unknowns,
                             const MPI_Comm &communicator)
{
  if (is_dual || (has_begun && interface.has_constant_fluxes()))
    return;
  const auto w = augmentations(interface, t, unknowns, communicator);
  for (unsigned int i = 0; i < terms.size(); ++i)
    terms[i].augmentation = w[i];
  has_begun = true;
}

/// w_j does not change the solution, but if it is decades too large, rounding of w_j g_j drowns the fluxes.
template <int dim>
bool Mortar<dim>::update_penalties(const Interface<dim> &interface, const double t, const ValuesOf &unknowns,
                                   const MPI_Comm &communicator)
{
  const double largest_decrease = 100;
  if (is_dual || interface.has_constant_fluxes())
    return false;
  const auto w = augmentations(interface, t, unknowns, communicator);
  bool is_outdated = false;
  for (unsigned int i = 0; i < terms.size(); ++i)
    is_outdated = is_outdated || terms[i].augmentation > largest_decrease * w[i];
  if (dealii::Utilities::MPI::max(static_cast<int>(is_outdated), communicator) == 0)
    return false;
  for (unsigned int i = 0; i < terms.size(); ++i)
    terms[i].augmentation = w[i];
  return true;
}

template <int dim>
void Mortar<dim>::assemble_term(const unsigned int i, const std::vector<double> &unknowns,
                                std::vector<double> &residual, dealii::FullMatrix<double> *tangent) const
{
  const Term &term = terms[i];
  const unsigned int n = term.weights.size();
  if (n == 0) { // no function: the multiplier is zero
    residual[0] = unknowns[0];
    if (tangent != nullptr)
      (*tangent)(0, 0) = 1;
    return;
  }
  const double g = term.g(unknowns);
  for (unsigned int k = 0; k < n; ++k)
    residual[k] = term.weights[k] * (unknowns[n] + term.augmentation * g);
  residual[n] = g;
  if (tangent == nullptr)
    return;
  for (unsigned int k = 0; k < n; ++k) {
    for (unsigned int l = 0; l < n; ++l)
      (*tangent)(k, l) = term.augmentation * term.weights[k] * term.weights[l];
    (*tangent)(k, n) = (*tangent)(n, k) = term.weights[k];
  }
}

template <int dim>
double Mortar<dim>::magnitude_of_term(const unsigned int i, const std::vector<double> &unknowns) const
{
  double sum = std::abs(terms[i].constant);
  for (unsigned int k = 0; k < terms[i].weights.size(); ++k)
    sum += std::abs(terms[i].weights[k] * unknowns[k]);
  return sum;
}

template <int dim>
void Mortar<dim>::find_multipliers(const Interface<dim> &, const ValueAt &solution, const ValueAt &force,
                                   const MPI_Comm &communicator)
{
  std::map<Index, double> lambda;
  transmitted.clear();
  const auto transmit = [&](const auto &row, const double influx) {
    transmitted.push_back(
        {row.field, row.component, {{-row.source_weight * influx, -row.destination_weight * influx}}});
  };
  if (is_dual)
    for (const auto &[dof, row] : space->rows) {
      lambda[dof] = -force(dof) / row.diagonal * source_share(dof);
      if (const auto line = shares_of_force.find(dof); line != shares_of_force.end())
        transmitted.push_back(
            {row.field,
             row.component,
             {{line->second[source] * force(dof), line->second[destination] * force(dof)}}});
    }
  else
    for (const Term &term : terms) {
      const double multiplier_value = solution(term.dofs.back());
      lambda[term.node] = multiplier_value;
      if (term.weights.empty())
        continue;
      std::vector<double> unknowns;
      for (const Index dof : term.dofs)
        unknowns.push_back(solution(dof));
      transmit(space->rows.at(term.node), multiplier_value + term.augmentation * term.g(unknowns));
    }
  space->set_coefficients(lambda, communicator);
}

template <int dim>
void Mortar<dim>::numerical_flux(const Interface<dim> &interface, const TiedField &field,
                                 const unsigned int q, const std::array<State<dim>, 2> &state,
                                 const std::array<std::vector<double>, 2> &flux,
                                 const std::vector<double> &jump, std::vector<double> &result) const
{
  if (!space || !space->has_coefficients()) // the tie has not been active yet
    return Tie<dim>::numerical_flux(interface, field, q, state, flux, jump, result);
  for (unsigned int c = 0; c < result.size(); ++c)
    result[c] = space->value(field.index, c, q);
}

template <int dim>
NoteList Mortar<dim>::notes() const
{
  NoteList all;
  // the source's trace has kinks inside the destination's faces only if it is the coarser one
  if (ratios.stiffness > largest_stiffness_ratio && ratios.face_size < 0.9)
    all.push_back(note_on_stiff_destination(ratios.stiffness));
  if (ratios.stiffness > largest_stiffness_ratio && ratios.face_size > 1.1)
    all.push_back(note_on_fine_soft_source(ratios));
  if (loses_order)
    all.push_back(
        of_order("dual multipliers on triangles of degree 3 hold constants only, and the flux errs as with "
                 "degree 1. Set Multiplier space = standard, or use Type = Nitsche"));
  if (space && space->n_taken > 0)
    all.push_back(of_multipliers("no multipliers at " + std::to_string(space->n_taken) +
                                 " unknowns that are prescribed or belong to another interface too"));
  if (space && space->n_hardly_covered > 0)
    all.push_back(of_multipliers("no multipliers at " + std::to_string(space->n_hardly_covered) +
                                 " unknowns of faces that are hardly covered"));
  if (space && space->n_on_axis > 0)
    all.push_back(of_multipliers("no dual multipliers at " + std::to_string(space->n_on_axis) +
                                 " unknowns on the axis: their neighbours stand in for them"));
  return all;
}

const bool registered =
    add_tie<Mortar>("mortar", "The jump is orthogonal to multipliers on the destination.");

} // namespace

} // namespace dovetail
