// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Unknowns -> state -> response at points of a cell. With SidePoints, the only way to the laws.

#pragma once

#include <dovetail/domain/domain.h>

#include <dovetail/time/rates.h>

#include <deal.II/fe/fe_values.h>

#include <vector>

namespace dovetail {

/// Fill the traces and gradients of a state from a point's shape values and gradients (CellLayout) and the
/// local unknowns.
template <int dim>
void evaluate_state(const CellLayout<dim> &layout, const double *shape_values,
                    const dealii::Tensor<1, dim> *shape_gradients, const double *unknowns, State<dim> &state);

/// The state of a domain at one point of a cell after another, and the response of its material. One object
/// per thread; reuse it for all cells.
template <int dim>
class CellPoints
{
public:
  CellPoints(const Domain<dim> &domain, double t);
  CellPoints(const CellPoints &) = delete;

  /// The rates of the states that come next, at points of a cell with these unknowns: those of @p rates
  /// (ghosted), or none (nullptr). Nothing happens if no term of the material asks for rates.
  void set_rates(const Rates *rates, const std::vector<dealii::types::global_dof_index> &dofs);

  /// The cell of points at any X that come next.
  void enter(const typename dealii::Triangulation<dim>::active_cell_iterator &cell_of_points)
  {
    if (domain.memory)
      cell = cell_of_points;
  }
  /// Point @p q of a cell or of its face, of the layout's shape_element(), with the cell's unknowns in the
  /// order component, node.
  void reinit(const dealii::FEValuesBase<dim> &values, unsigned int q, const std::vector<double> &unknowns);
  /// All points of @p values at once, which is faster: evaluate the traces and gradients there. go_to() then
  /// makes the state of one of them; shape_values() and shape_gradients() are those of the last reinit().
  /// @p values must live, and stay at its cell, until the last go_to(). @p needed: by component; the values
  /// of others are NaN there. Empty: all.
  void enter(const dealii::FEValuesBase<dim> &values, const std::vector<double> &unknowns,
             const std::vector<bool> &needed = {});
  /// Before go_to(): State::linearised_at has these unknowns.
  void enter_linearised(const std::vector<double> &unknowns);
  void go_to(unsigned int q);
  /// A point X anywhere in that cell, where the shape functions of the layout have these values and
  /// gradients.
  void reinit(const dealii::Point<dim> &X, const double *shape_values,
              const dealii::Tensor<1, dim> *shape_gradients, const std::vector<double> &unknowns);
  /// The state gets the values and rates of node @p a of the cell, of each component that has it; its X and
  /// gradients stay.
  void move_to_node(unsigned int a, const std::vector<double> &unknowns);
  /// The response at the state; @return false if a law is not defined there.
  bool evaluate(const bool with_derivatives) { return evaluate(with_derivatives, response); }
  bool evaluate(const bool with_derivatives, Response<dim> &result) const
  {
    return domain.material.evaluate(state, with_derivatives, result);
  }
  bool evaluate(const std::vector<Asked> &asked, Response<dim> &result) const
  {
    return domain.material.evaluate(state, asked, result);
  }
  /// The fluxes at all points of enter() where the material is uniform (Material::is_uniform()) and has the
  /// derivatives of @p response everywhere: of the components that @p are_needed, times @p weights,
  /// [component][point].
  void evaluate_uniform(const Response<dim> &response, const std::vector<bool> &are_needed,
                        const std::vector<double> &weights,
                        std::vector<dealii::Tensor<1, dim>> &fluxes) const;

  /// Material::evaluate_storage() into a response of its own, beside that of evaluate().
  bool evaluate_storage(Response<dim> &storage) const
  {
    return domain.material.evaluate_storage(state, storage);
  }
  void curvature(const std::vector<dealii::Tensor<1, dim>> &w, dealii::FullMatrix<double> &result) const
  {
    domain.material.curvature(state, w, result);
  }
  dealii::Tensor<2, 3> cauchy_stress() const { return domain.material.cauchy_stress(state); }
  dealii::Tensor<2, 3> displacement_gradient() const { return domain.material.displacement_gradient(state); }
  double energy_density() const { return domain.material.energy_density(state); }

  const std::vector<double> &shape_values() const { return shape; } ///< of the first reinit()
  const std::vector<dealii::Tensor<1, dim>> &shape_gradients() const { return gradient; }

  const Domain<dim> &domain;
  State<dim> state; ///< may be changed before evaluate()
  Response<dim> response;

private:
  void remember(); ///< at the state's X
  void set_position(const dealii::Point<dim> &X);
  /// Of each component that stores by @p at (numbers of the cell's unknowns, component).
  template <typename Function>
  void evaluate_rates(const Function &at);

  /// [component][point]
  struct AtPoints
  {
    std::vector<double> values;
    std::vector<dealii::Tensor<1, dim>> gradients;
  };
  void interpolate(const std::vector<double> &unknowns, const std::vector<bool> &needed, AtPoints &result);

  const dealii::FEValuesBase<dim> *points = nullptr; ///< of enter()
  AtPoints present, before;
  State<dim> linearised;            ///< of enter_linearised()
  std::vector<const double *> rows; ///< scratch

  std::vector<double> shape;
  std::vector<dealii::Tensor<1, dim>> gradient;
  std::vector<double> trial_memory;
  typename dealii::Triangulation<dim>::active_cell_iterator cell; ///< of the point; only with memory
  std::vector<double> rest, second_rest;                          ///< of the rates of the cell's unknowns
  std::vector<std::vector<double>> past;                          ///< of the cell's unknowns
};

} // namespace dovetail
