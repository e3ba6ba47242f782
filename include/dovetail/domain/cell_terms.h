// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The one weak form on one cell, whatever the physics.

#pragma once

#include <dovetail/domain/cell_operator.h>
#include <dovetail/domain/cell_points.h>
#include <dovetail/domain/flows.h>
#include <dovetail/domain/open_boundary.h>
#include <dovetail/domain/point_products.h>

#include <deal.II/base/table.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/lac/full_matrix.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <utility>
#include <vector>

namespace dovetail {

/// Those whose capacity (@p order_in_time 1) or mass (2) is lumped: all that store in this way, if the scene
/// asks for `Lumped capacity` or `Lumped mass`.
/// @throw UserError if row sums of shape functions are negative or zero somewhere, as those of a degree
/// higher than 1 are on triangles and tetrahedra; capacities are lumped with the degree 1 only.
template <int dim>
std::vector<unsigned int> lumped_components(const Domain<dim> &domain, unsigned int order_in_time);

/// Residual and tangent of
/// @f[ R(\delta) = \int_K A\cdot\nabla\delta B + S\cdot\delta B - f\cdot\delta B \,dV
///                 - \int_{\partial K} h(B)\cdot\delta B \,dA @f]
/// and, for components c that are prescribed weakly (Nitsche 1971), with e = B_c - g_c,
/// @f[ \int_{\partial K} - A_c\cdot N\,\delta B_c - \delta A_c\cdot N\,e + \gamma\,e\,\delta B_c\,dA @f]
/// with the fluxes A and sources S of the domain's material, the given sources f and the boundary influxes h
/// of its conditions. Gauss quadrature with degree + 1 points per direction. One object per thread; reuse it
/// for all cells.
template <int dim>
class CellTerms
{
public:
  explicit CellTerms(const Domain<dim> &domain);

  /// The rates of all unknowns (ghosted) in the step, kept by reference; nullptr: none are known.
  void set_rates(const Rates *step_rates) { rates = step_rates; }
  /// The state (ghosted) whose tangent has led to the next one, kept by reference, if tangents shall have the
  /// stress that it predicts (SolidTerm); nullptr: that of the state itself. For laws of large strain.
  void linearise_at(const Rates::Vector *state) { linearised_at = state; }

  /// From now on the terms of a field's own tangent go there, and not to the matrix of a cell. Boundaries'
  /// still do.
  void give_tangent_to(const Field &field, CellOperator<dim> &cells);
  /// From now on assemble() leaves what assemble_given() adds out of the residual, or what
  /// assemble_boundary() adds; the latter stays in the tangent.
  void leave_out_given() { leaves_out_given = true; }
  void leave_out_boundary() { leaves_out_boundary = true; }
  /// From now on the tangent has no entries of a field by another one.
  void leave_out_coupling(const Field &field, const Field &by);
  /// From now on assemble() leaves out the rows of fields of which nothing is asked, and of the tangent those
  /// of fields whose derivatives are not.
  void ask_for(const std::vector<Asked> &of_fields);
  const Domain<dim> &body() const { return domain; }
  /// Whether some condition has a tangent on a face of the cell.
  bool has_boundary_tangent(const typename Domain<dim>::cell_iterator &cell) const;
  /// Mark the pairs of local unknowns that it couples.
  void add_boundary_couplings(const typename Domain<dim>::cell_iterator &cell,
                              dealii::Table<2, bool> &couples) const;
  bool lumps_storage() const { return !lumped.empty(); } ///< on the diagonal of the tangent
  /// Whether the tangent of every cell has entries, and of this one.
  bool has_entries() const { return is_any_asked(pairs) || lumps_storage(); }
  bool has_entries(const typename Domain<dim>::cell_iterator &cell) const
  {
    return has_entries() || has_boundary_tangent(cell);
  }

  /// Overwrites @p residual and, if @p tangent is not nullptr, the tangent. @return false if a law is not
  /// defined at the state of a quadrature point; the results are then incomplete.
  bool assemble(const typename Domain<dim>::cell_iterator &cell, double t,
                const std::vector<double> &unknowns, std::vector<double> &residual,
                dealii::FullMatrix<double> *tangent);

  /// The part of the residual without the fluxes and what is stored: the sources of the laws minus the given
  /// ones and the boundary influxes. Overwrites @p residual. @return false if the cell has none of them; it
  /// is zero then.
  bool assemble_loads(const typename Domain<dim>::cell_iterator &cell, double t,
                      const std::vector<double> &unknowns, std::vector<double> &residual);

  /// The part of assemble_loads() that depends on no state: the given sources, without those of the laws.
  /// Overwrites @p residual.
  void assemble_given(const typename Domain<dim>::cell_iterator &cell, double t,
                      std::vector<double> &residual);
  /// That of the conditions on its boundary. Overwrites @p residual and, if @p tangent is not nullptr, its
  /// derivative. @return false if a law is not defined.
  bool assemble_boundary(const typename Domain<dim>::cell_iterator &cell, double t,
                         const std::vector<double> &unknowns, std::vector<double> &residual,
                         dealii::FullMatrix<double> *tangent = nullptr);

  /// What the laws remember of a state: the trial of the domain's memory. @return false if one is not defined
  /// there.
  bool evaluate_memory(const typename Domain<dim>::cell_iterator &cell, double t,
                       const std::vector<double> &unknowns);
  /// Of the state before the first step, in the trial. @pre the material looks at it
  void look_at_start(const typename Domain<dim>::cell_iterator &cell, const std::vector<double> &unknowns);
  /// The part of what is stored. Overwrites @p residual and, if @p tangent is not nullptr, its derivative.
  /// @return false if nothing is stored; both are zero then.
  bool assemble_storage(const typename Domain<dim>::cell_iterator &cell, double t,
                        const std::vector<double> &unknowns, std::vector<double> &residual,
                        dealii::FullMatrix<double> *tangent = nullptr);

  /// What the given sources have put into all cells of assemble() since forget_given(), by component, but for
  /// cells where assemble() has added something of conditions. nullptr: not known, as sources depend on the
  /// state, too.
  const Flows *given_flows() const;
  void forget_given() { given = Flows(n); }

  /// Of the last assemble(), by local unknown: the sum of the absolute contributions of all points.
  const std::vector<double> &forces() const { return force_sizes; }
  /// By local unknown, of the tangent that has been given away or left out: at least sum_j |K_ij x_j|.
  const std::vector<double> &products() const { return product_sizes; }
  /// From now on for these sizes in place of |x_j|, kept by reference.
  void size_products_by(const std::vector<double> &sizes) { sizes_of_unknowns = &sizes; }
  /// How many roundings stand behind an entry of the residual: the terms of a gradient, of the product with
  /// the flux, of the sum over the points, and of that over the cells at a node.
  unsigned int longest_sum() const
  {
    return layout.n_shapes() + dim + cell_values.n_quadrature_points + (1u << dim);
  }

private:
  void add(const unsigned int i, const double contribution, std::vector<double> &residual)
  {
    residual[i] += contribution;
    force_sizes[i] += std::abs(contribution);
  }

  using cell_iterator = typename Domain<dim>::cell_iterator;
  void enter(const cell_iterator &cell); ///< its points
  /// Likewise, but cell_values stay at the cell that they are at if that has only been moved here.
  void enter_or_move_to(const cell_iterator &cell);
  /// Fluxes, and sources of the laws, from all points of the cell; @p responses if @p tangent is not nullptr.
  /// @return false if a law is not defined.
  bool add_laws(const cell_iterator &cell, const std::vector<double> &unknowns, std::vector<double> &residual,
                dealii::FullMatrix<double> *tangent);
  void find_uniform();
  /// Likewise where the material is uniform and no rates are known.
  bool add_uniform_laws(const cell_iterator &cell, const std::vector<double> &unknowns,
                        std::vector<double> &residual, dealii::FullMatrix<double> *tangent);
  void enter_without_tangent(const typename Domain<dim>::cell_iterator &cell, double t);
  void add_given(const typename Domain<dim>::cell_iterator &cell, double t,
                 const std::vector<double> &unknowns, std::vector<double> &residual,
                 dealii::FullMatrix<double> *tangent);
  bool meets_flux_condition(const typename Domain<dim>::cell_iterator &cell) const
  {
    return !flux_conditions.empty() && cell->at_boundary();
  }
  void add_source(double t, std::vector<double> &residual);
  void add_body_force(double t, const std::vector<double> &unknowns, std::vector<double> &residual,
                      dealii::FullMatrix<double> *tangent);
  /// The response of the laws at the current point.
  void add_fluxes(std::vector<double> &residual); ///< at all points
  void add_source_of_laws(const Response<dim> &response, double JxW, std::vector<double> &residual);
  void find_rates(const typename Domain<dim>::cell_iterator &cell);
  /// Where capacity is lumped the laws see no rates of scalars: see add_lumped_storage().
  void hide_lumped_rates();
  /// S_(c,a) = m_a S_c(B_a), what node a stores by itself with the row sums m_a = int phi_a dV, the part of
  /// the current point of them; where the capacity depends on X, at that point. @return false if a capacity
  /// is not defined there.
  bool add_lumped_storage(unsigned int q, double JxW, const std::vector<double> &unknowns,
                          std::vector<double> &residual, dealii::FullMatrix<double> *tangent);
  void add_storage_tangent(double JxW, dealii::FullMatrix<double> &tangent) const;
  bool add_storage_of_node(unsigned int a, double weight, std::vector<double> &residual,
                           dealii::FullMatrix<double> *tangent);
  /// The terms of the fluxes' derivatives, or those of the cell before if nothing can have changed.
  void add_tangent(dealii::FullMatrix<double> &tangent);
  void add_pairs(dealii::FullMatrix<double> &tangent);
  bool has_equal_derivatives(const Response<dim> &a, const Response<dim> &b) const;
  bool has_operator(unsigned int component) const;
  void find_sized();
  template <typename Visit>
  void for_each_tangent(const typename Domain<dim>::cell_iterator &cell, const Visit &visit) const;
  void give_away(const typename Domain<dim>::cell_iterator &cell, const std::vector<double> &unknowns);
  void find_sizes_at_points(const std::vector<double> &unknowns);
  void add_products_of_point(unsigned int q, double JxW, bool has_force);
  void add_up_products();
  bool add_boundary_terms(const typename Domain<dim>::cell_iterator &cell, double t,
                          const std::vector<double> &unknowns, std::vector<double> &residual,
                          dealii::FullMatrix<double> *tangent);
  void add_influx(const Condition<dim> &condition, const typename OpenBoundary<dim>::Point &point,
                  std::vector<double> &residual, dealii::FullMatrix<double> *tangent);
  /// @return false if a law is not defined there.
  bool add_weak_value(const Condition<dim> &condition, const typename OpenBoundary<dim>::Point &point,
                      double gamma, const std::vector<double> &unknowns, std::vector<double> &residual,
                      dealii::FullMatrix<double> *tangent);
  void add_weak_tangent(const Field &field, const std::vector<double> &factor,
                        const std::vector<double> &mismatch, const typename OpenBoundary<dim>::Point &point,
                        double gamma, dealii::FullMatrix<double> &tangent);

  const Domain<dim> &domain;
  const CellLayout<dim> &layout;
  const unsigned int n; ///< components
  dealii::FEValues<dim> cell_values;
  OpenBoundary<dim> open_boundary;
  CellPoints<dim> point;
  std::vector<Response<dim>> responses;       ///< at the points of a cell whose tangent is asked for
  std::vector<dealii::Tensor<1, dim>> fluxes; ///< [component][point], times the weights of the points
  /// The shape functions of a component at all points. Those of a cell that was only moved stay.
  struct Tables
  {
    void enter_cell(const Domain<dim> &domain, const dealii::FEValues<dim> &cell_values);
    const ShapeTable &table(const CellLayout<dim> &layout, unsigned int component, bool with_value,
                            const dealii::FEValues<dim> &cell_values);

    struct Table : ShapeTable
    {
      bool is_of_this_cell = false;
    };
    std::map<std::pair<unsigned int, bool>, Table> all; ///< by first shape, with values
    std::vector<double> JxW;                            ///< of the points
  };
  Tables tables;
  /// Of cells of degree 1 that are moved to each other: what stands in cell_values, and the points of the
  /// cell where it is not these. Cells around an axis are not equal.
  struct Move
  {
    explicit Move(const Domain<dim> &domain)
        : is_possible(domain.mapping_degree() == 1 && !domain.measure.is_axisymmetric())
    {
    }
    void begin_at(const cell_iterator &cell);
    /// Whether @p cell is where the first one has been moved to, up to rounding.
    bool reaches(const cell_iterator &cell, const std::vector<dealii::Point<dim>> &points_at_begin);

    const bool is_possible;
    bool is_done = false;
    std::vector<dealii::Point<dim>> vertices, points;
    double tolerance = 0;
  };
  Move move;
  const std::vector<dealii::Point<dim>> &points_of_cell() const
  {
    return move.is_done ? move.points : cell_values.get_quadrature_points();
  }
  std::vector<double> derivatives; // scratch
  /// Of the last cell whose points all had one and the same tangent of the laws.
  dealii::FullMatrix<double> uniform_tangent;
  Response<dim> uniform_response;
  bool has_uniform_tangent = false;
  bool is_uniform = false;            ///< the material, in the fields of which something is asked
  bool has_uniform_responses = false; ///< those of all cells
  struct Pair                         ///< of components of which the first depends on the second
  {
    unsigned int c, d, index;
    Coupling coupling;
  };
  bool is_any_asked(const std::vector<Pair> &of_pairs) const
  {
    return std::any_of(of_pairs.begin(), of_pairs.end(),
                       [this](const Pair &pair) { return is_asked[pair.c]; });
  }
  std::vector<Pair> pairs, pairs_without_entries;
  std::vector<Asked> asked_with_tangent, asked_alone; ///< by field
  std::vector<Asked> asked_of_uniform;                ///< derivatives in place of responses
  std::vector<bool> is_asked;                         ///< by component: its rows of the tangent
  std::vector<bool> is_in_residual;                   ///< by component: its rows
  std::vector<bool> is_needed; ///< by component: its state, for these rows; empty: all of them
  std::vector<bool> is_sized;  ///< by component: what it multiplies in pairs_without_entries
  std::vector<std::pair<Field, CellOperator<dim> *>> operators; ///< of the latter, but for what is left out
  std::vector<unsigned int> with_source;                        ///< components for which the laws have one
  bool has_loads = false;                                       ///< some of them is not storage alone
  const Rates *rates = nullptr;
  const Rates::Vector *linearised_at = nullptr;
  const std::vector<unsigned int> lumped; ///< components whose capacity is
  Response<dim> lumped_response;
  std::vector<double> node_weights;                  ///< row sums of a cell
  dealii::FullMatrix<double> lumped_tangent;         ///< of a cell
  std::vector<dealii::types::global_dof_index> dofs; ///< scratch
  std::vector<double> unknowns_before;               // likewise
  std::vector<const Condition<dim> *> flux_conditions;
  bool leaves_out_given = false, leaves_out_boundary = false;
  std::vector<double> left_out; // scratch
  Flows given;
  std::vector<double> given_of_cell; ///< by component, of the last cell
  std::vector<std::pair<const Expression *, unsigned int>> source_of_component;
  std::vector<double> source_at_points; // scratch
  const std::vector<double> *sizes_of_unknowns = nullptr;
  /// sum_a |phi_a x_a|, and of each derivative, [component][point]; and what they give to flux and source.
  std::vector<double> value_sizes, source_sizes;
  std::vector<dealii::Tensor<1, dim>> gradient_sizes, flux_sizes;
  std::vector<double> force_sizes, product_sizes;
};

} // namespace dovetail
