// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/point_products.h>

#include <dovetail/domain/cell_operator.h>

#include <deal.II/base/aligned_vector.h>
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_dgq.h>
#include <deal.II/fe/fe_tools.h>
#include <deal.II/fe/mapping_q1.h>
#include <deal.II/grid/grid_generator.h>
#include <deal.II/matrix_free/fe_evaluation.h>
#include <deal.II/matrix_free/matrix_free.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace dovetail {

namespace {

using Lanes = dealii::VectorizedArray<double>;
using dealii::internal::MatrixFreeFunctions::GeometryType;

template <int dim>
void reinit(dealii::MatrixFree<dim, double> &matrix_free, const dealii::Mapping<dim> &mapping,
            const dealii::DoFHandler<dim> &nodes, const unsigned int degree)
{
  typename dealii::MatrixFree<dim, double>::AdditionalData data;
  data.tasks_parallel_scheme = dealii::MatrixFree<dim, double>::AdditionalData::none;
  data.mapping_update_flags = dealii::update_gradients | dealii::update_JxW_values;
  dealii::AffineConstraints<double> none;
  none.close();
  matrix_free.reinit(mapping, nodes, none, dealii::QGauss<1>(degree + 1), data);
}

/// Which cell a batch of the loop has in a lane, and the geometry of all; shared by copies.
template <int dim>
struct Cells
{
  explicit Cells(const Domain<dim> &domain);

  unsigned int n_slots() const { return matrix_free.n_cell_batches() * Lanes::size(); }
  bool is_filled(const unsigned int slot) const
  {
    return slot % Lanes::size() < matrix_free.n_active_entries_per_cell_batch(slot / Lanes::size());
  }
  typename dealii::Triangulation<dim>::active_cell_iterator cell(const unsigned int slot) const
  {
    return matrix_free.get_cell_iterator(slot / Lanes::size(), slot % Lanes::size());
  }

  /// The functions of the domain's element by cell; nothing is shared between cells, and so the numbers of
  /// unknowns are contiguous. Those of the domain itself may belong to any number of fields and ranks.
  dealii::FE_DGQ<dim> element;
  dealii::DoFHandler<dim> nodes;
  dealii::MatrixFree<dim, double> matrix_free;
  std::vector<unsigned int> slot_of_cell; ///< by active cell index
};

template <int dim>
Cells<dim>::Cells(const Domain<dim> &domain) : element(domain.degree), nodes(domain.mesh())
{
  nodes.distribute_dofs(element);
  reinit(matrix_free, domain.mapping(), nodes, domain.degree);
  slot_of_cell.assign(domain.mesh().n_active_cells(), dealii::numbers::invalid_unsigned_int);
  for (unsigned int slot = 0; slot < n_slots(); ++slot)
    if (is_filled(slot))
      slot_of_cell[cell(slot)->active_cell_index()] = slot;
}

/// The element on unit cells, one for each lane: gradients in the cell's own coordinates.
template <int dim>
struct UnitCells
{
  explicit UnitCells(unsigned int degree);

  dealii::Triangulation<dim> mesh;
  dealii::DoFHandler<dim> nodes;
  dealii::MatrixFree<dim, double> matrix_free;
};

template <int dim>
UnitCells<dim>::UnitCells(const unsigned int degree) : nodes(mesh)
{
  dealii::Point<dim> far;
  std::vector<unsigned int> n_cells(dim, 1);
  n_cells[0] = Lanes::size();
  for (unsigned int d = 0; d < dim; ++d)
    far[d] = n_cells[d];
  dealii::GridGenerator::subdivided_hyper_rectangle(mesh, n_cells, dealii::Point<dim>(), far);
  nodes.distribute_dofs(dealii::FE_DGQ<dim>(degree));
  reinit(matrix_free, dealii::MappingQ1<dim>(), nodes, degree);
}

template <int dim, int n_components>
class CellOperatorOf : public CellOperator<dim>
{
public:
  CellOperatorOf(const Domain<dim> &domain, const Field &field);

  std::unique_ptr<CellOperator<dim>> copy() const override { return std::make_unique<CellOperatorOf>(*this); }
  void for_each_unknown(const std::function<void(dealii::types::global_dof_index)> &visit) const override;
  void number(const std::function<int(dealii::types::global_dof_index)> &index) override;
  void begin_tangent() override { has_any = false; }
  void set_tangent(unsigned int active_cell_index, unsigned int q, double factor,
                   const Response<dim> &response) override;
  void finish_tangent() override;
  void add_tangent(double factor, const CellOperator<dim> &other) override;
  void add_product(const double *x, double *y, bool of_symmetric_part) const override;
  void add_diagonal(double *diagonal) const override;
  void for_each_cell(const typename CellOperator<dim>::Prolongation &P,
                     const std::function<void(const std::vector<int> &columns)> &visit) const override;
  void for_each_restriction(const typename CellOperator<dim>::Prolongation &P,
                            const typename CellOperator<dim>::VisitCell &visit) const override;

private:
  static constexpr unsigned int n_slopes = n_components * dim; ///< of the gradient
  using Evaluation = dealii::FEEvaluation<dim, -1, 0, n_components, double>;
  using Array = dealii::AlignedVector<Lanes>;

  /// What products need beside the operator.
  struct Work
  {
    explicit Work(const CellOperatorOf &K)
        : cell(K.cells->matrix_free), unit(K.unit_cells->matrix_free), state(K.n_state * K.n_points),
          response(state), in_space(state), flux_in_space(state), J((dim * dim + 1) * K.n_points), JxW_J(J)
    {
      unit.reinit(0);
    }
    Evaluation cell, unit;
    Array state, response, in_space, flux_in_space; ///< [slope, or value][point]
    /// grad phi = J grad phi of the unit cell, and 1 for the value: [entry][point]; and JxW times that
    Array J, JxW_J;
    bool is_cartesian = false;
  };

  // Derivatives at a point of the flux, then of the source, by the gradient, then by the value. Of A there is
  // the upper triangle if it is symmetric.
  unsigned int at(const unsigned int row, const unsigned int column) const
  {
    return entry_numbers[row * n_state + column];
  }
  void number_entries();
  static bool is_slope(const unsigned int row) { return row < n_slopes; }
  Lanes &derivative(const unsigned int batch, const unsigned int entry, const unsigned int q)
  {
    return tangents[(std::size_t(batch) * n_entries + entry) * n_points + q];
  }
  template <typename Visit>
  void for_each_dof(const Visit &visit) const;
  void make_terms();
  void multiply_at_points(Work &work, unsigned int batch, bool of_symmetric_part) const;
  void find_slopes();
  const Lanes *state(Work &work) const;
  void submit(Work &work, bool with_values) const;
  void start(Work &work, unsigned int batch) const;
  void read_geometry(Work &work) const;
  void refer_to_unit_cell(const Evaluation &cell, unsigned int q, const Lanes *T,
                          std::vector<Lanes> &result) const;
  void refer_to_unit_cells();
  void expand();

  const Domain<dim> &domain;
  const Field field;
  bool is_symmetric, has_values, has_sources; ///< the last two: V, W or M; W or M
  unsigned int n_of_A, n_state, n_entries, n_nodes, n_points;
  std::vector<unsigned int> entry_numbers;
  std::shared_ptr<const Cells<dim>> cells;
  std::shared_ptr<const UnitCells<dim>> unit_cells;
  std::vector<unsigned int> place_of_slope; ///< [slope][point] of phi.begin_gradients()
  bool slopes_are_in_order = true;
  std::vector<unsigned int> hierarchic;    ///< number in the domain's element of a lexicographic node
  std::shared_ptr<std::vector<int>> index; ///< [slot][component][lexicographic node]; shared by copies
  bool has_any = false, is_uniform = true;
  std::vector<double> entries; ///< scratch
  /// Of one cell in space, if all points have the same; else of each batch and, once finished, in unit cells:
  /// JxW J^T A J, JxW J^T V, JxW J^T W, JxW M.
  Array tangents;
  std::vector<PointTerm> product, symmetric_product;          ///< of what is not zero
  std::array<std::vector<PointTerm>, 2> to_space, from_space; ///< of any cell, of a Cartesian one
};

template <int dim, int n_components>
CellOperatorOf<dim, n_components>::CellOperatorOf(const Domain<dim> &domain, const Field &field)
    : domain(domain), field(field), is_symmetric(true), has_values(false), has_sources(false),
      n_nodes(domain.layout().n_nodes(field.first_component)), n_points(domain.cell_quadrature().size()),
      cells(std::make_shared<Cells<dim>>(domain)),
      unit_cells(std::make_shared<UnitCells<dim>>(domain.degree)),
      hierarchic(dealii::FETools::lexicographic_to_hierarchic_numbering<dim>(domain.degree)),
      index(std::make_shared<std::vector<int>>())
{
  for (unsigned int f = 0; f < domain.fields().size(); ++f)
    if (domain.fields()[f].name == field.name)
      is_symmetric = domain.material.is_symmetric(f);
  for (unsigned int c = 0; c < n_components; ++c)
    for (unsigned int d = 0; d < n_components; ++d) {
      const Coupling coupling =
          domain.material.coupling(field.first_component + c, field.first_component + d);
      has_values = has_values || coupling.flux_by_value || coupling.in_source();
      has_sources = has_sources || coupling.in_source();
    }
  has_sources = has_sources || domain.body_force().depends_on_displacement();
  has_values = has_values || has_sources;
  n_of_A = is_symmetric ? n_slopes * (n_slopes + 1) / 2 : n_slopes * n_slopes;
  n_state = n_slopes + (has_values ? n_components : 0);
  n_entries = n_of_A + (has_values ? n_components * (2 * n_slopes + n_components) : 0);
  number_entries();
  find_slopes();
  entries.resize(n_entries);
  tangents.resize(n_entries * n_points);
  for (const bool is_cartesian : {false, true})
    for (unsigned int row = 0; row < n_state; ++row) {
      const unsigned int c = row / dim, j = row % dim;
      if (!is_slope(row))
        to_space[is_cartesian].push_back({row, row, dim * dim, 1.});
      for (unsigned int l = 0; is_slope(row) && l < dim; ++l)
        if (l == j || !is_cartesian)
          to_space[is_cartesian].push_back({row, c * dim + l, j * dim + l, 1.});
    }
  for (const unsigned int k : {0, 1})
    for (const PointTerm &term : to_space[k])
      from_space[k].push_back({term.from, term.to, term.entry, 1.});
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::number_entries()
{
  const auto number = [this](const unsigned int row, const unsigned int column) {
    if (is_slope(row) && is_slope(column) && !is_symmetric)
      return row * n_slopes + column;
    if (is_slope(row) && is_slope(column)) {
      const unsigned int i = std::min(row, column), j = std::max(row, column);
      return i * n_slopes - i * (i + 1) / 2 + j;
    }
    if (is_slope(row))
      return n_of_A + row * n_components + (column - n_slopes);
    return n_of_A + n_slopes * n_components + (row - n_slopes) * n_state + column;
  };
  for (unsigned int row = 0; row < n_state; ++row)
    for (unsigned int column = 0; column < n_state; ++column)
      entry_numbers.push_back(number(row, column));
}

template <int dim, int n_components>
template <typename Visit>
void CellOperatorOf<dim, n_components>::for_each_dof(const Visit &visit) const
{
  std::vector<dealii::types::global_dof_index> dofs;
  for (unsigned int slot = 0; slot < cells->n_slots(); ++slot)
    if (cells->is_filled(slot)) {
      domain.cell_dofs(domain.dof_cell(cells->cell(slot)), dofs);
      for (unsigned int c = 0; c < n_components; ++c)
        for (unsigned int a = 0; a < n_nodes; ++a)
          visit((slot * n_components + c) * n_nodes + a,
                dofs[domain.layout().index(field.first_component + c, hierarchic[a])]);
    }
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::for_each_unknown(
    const std::function<void(dealii::types::global_dof_index)> &visit) const
{
  for_each_dof([&](unsigned int, const auto dof) { visit(dof); });
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::number(
    const std::function<int(dealii::types::global_dof_index)> &index_of)
{
  index->assign(cells->n_slots() * n_components * n_nodes, -1);
  for_each_dof([&](const unsigned int i, const auto dof) { (*index)[i] = index_of(dof); });
}

/// From now on each point has its own derivatives.
template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::expand()
{
  const Array uniform(tangents);
  const std::size_t n = cells->matrix_free.n_cell_batches();
  tangents.resize_fast(n * uniform.size());
  for (std::size_t batch = 0; batch < n; ++batch)
    std::copy(uniform.begin(), uniform.end(), tangents.begin() + batch * uniform.size());
  is_uniform = false;
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::set_tangent(const unsigned int active_cell_index,
                                                    const unsigned int q, const double factor,
                                                    const Response<dim> &response)
{
  const unsigned int n = domain.n_components(), first = field.first_component;
  for (unsigned int c = 0; c < n_components; ++c)
    for (unsigned int d = 0; d < n_components; ++d) {
      const unsigned int pair = (first + c) * n + first + d;
      for (unsigned int J = 0; J < dim; ++J)
        for (unsigned int L = 0; L < dim; ++L)
          entries[at(c * dim + J, d * dim + L)] = factor * response.by_gradient[pair][J][L];
      for (unsigned int J = 0; has_values && J < dim; ++J) {
        entries[at(c * dim + J, n_slopes + d)] = factor * response.by_value[pair][J];
        entries[at(n_slopes + c, d * dim + J)] = factor * response.source_by_gradient[pair][J];
      }
      if (has_values)
        entries[at(n_slopes + c, n_slopes + d)] = factor * response.source_by_value[pair];
    }
  if (is_uniform && !has_any)
    for (unsigned int e = 0; e < n_entries; ++e)
      std::fill_n(&derivative(0, e, 0), n_points, Lanes(entries[e]));
  has_any = true;
  bool is_same = is_uniform;
  for (unsigned int e = 0; is_same && e < n_entries; ++e)
    is_same = entries[e] == derivative(0, e, 0)[0];
  if (is_same)
    return;
  if (is_uniform)
    expand();
  const unsigned int slot = cells->slot_of_cell[active_cell_index];
  for (unsigned int e = 0; e < n_entries; ++e)
    derivative(slot / Lanes::size(), e, q)[slot % Lanes::size()] = entries[e];
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::finish_tangent()
{
  if (!is_uniform)
    refer_to_unit_cells();
  make_terms();
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::make_terms()
{
  product.clear();
  symmetric_product.clear();
  for (unsigned int row = 0; row < n_state; ++row)
    for (unsigned int column = 0; column < n_state; ++column) {
      const unsigned int entry = at(row, column), transposed = at(column, row);
      const bool is_zero = is_uniform && tangents[entry * n_points][0] == 0;
      if (!is_zero)
        product.push_back({row, column, entry, 1.});
      if (!is_zero && entry == transposed)
        symmetric_product.push_back({row, column, entry, 1.});
      else if (!is_zero) {
        symmetric_product.push_back({row, column, entry, 0.5});
        symmetric_product.push_back({column, row, entry, 0.5});
      }
    }
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::add_tangent(const double factor, const CellOperator<dim> &other)
{
  const auto &summand = dynamic_cast<const CellOperatorOf &>(other);
  if (is_uniform && !summand.is_uniform) {
    expand();
    refer_to_unit_cells();
  }
  if (!is_uniform && summand.is_uniform) {
    CellOperatorOf expanded(summand);
    expanded.expand();
    expanded.refer_to_unit_cells();
    add_tangent(factor, expanded);
    return;
  }
  for (std::size_t i = 0; i < tangents.size(); ++i)
    tangents[i] += factor * summand.tangents[i];
  make_terms();
}

/// The derivatives at a point, by the gradient in the unit cell and times the weight: with grad phi = J grad
/// phi of the unit cell, JxW J^T A J, JxW J^T V, JxW J^T W, JxW M.
template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::refer_to_unit_cell(const Evaluation &cell, const unsigned int q,
                                                           const Lanes *T, std::vector<Lanes> &result) const
{
  const dealii::Tensor<2, dim, Lanes> J = cell.inverse_jacobian(q);
  const Lanes JxW = cell.JxW(q);
  std::vector<Lanes> half(n_state * n_state); // T J
  for (unsigned int row = 0; row < n_state; ++row)
    for (unsigned int column = 0; column < n_state; ++column)
      for (unsigned int j = 0; j < (is_slope(column) ? dim : 1); ++j) {
        const unsigned int from = is_slope(column) ? column - column % dim + j : column;
        half[row * n_state + column] +=
            T[at(row, from) * n_points + q] * (is_slope(column) ? J[j][column % dim] : Lanes(1.));
      }
  result.assign(n_entries, Lanes());
  for (unsigned int row = 0; row < n_state; ++row)
    for (unsigned int column = is_symmetric && is_slope(row) ? row : 0; column < n_state; ++column)
      for (unsigned int j = 0; j < (is_slope(row) ? dim : 1); ++j) {
        const unsigned int from = is_slope(row) ? row - row % dim + j : row;
        result[at(row, column)] +=
            JxW * half[from * n_state + column] * (is_slope(row) ? J[j][row % dim] : Lanes(1.));
      }
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::refer_to_unit_cells()
{
  Evaluation cell(cells->matrix_free);
  std::vector<Lanes> at_point;
  for (unsigned int batch = 0; batch < cells->matrix_free.n_cell_batches(); ++batch) {
    cell.reinit(batch);
    for (unsigned int q = 0; q < n_points; ++q) {
      refer_to_unit_cell(cell, q, &derivative(batch, 0, 0), at_point);
      for (unsigned int e = 0; e < n_entries; ++e)
        derivative(batch, e, q) = at_point[e];
    }
  }
}

/// Where deal.II, which has moved it between its versions, keeps a gradient.
template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::find_slopes()
{
  Evaluation phi(unit_cells->matrix_free);
  phi.reinit(0);
  for (unsigned int q = 0; q < n_points; ++q) {
    typename Evaluation::gradient_type gradient;
    for (unsigned int row = 0; row < n_slopes; ++row) {
      const Lanes number = double(row * n_points + q) / phi.JxW(q);
      if constexpr (n_components == 1)
        gradient[row] = number;
      else
        gradient[row / dim][row % dim] = number;
    }
    phi.submit_gradient(gradient, q);
  }
  place_of_slope.resize(n_slopes * n_points);
  for (unsigned int k = 0; k < place_of_slope.size(); ++k) {
    place_of_slope[std::lround(phi.begin_gradients()[k][0])] = k;
    slopes_are_in_order = slopes_are_in_order && std::lround(phi.begin_gradients()[k][0]) == k;
  }
}

/// Gradients and values in the unit cell.
template <int dim, int n_components>
const Lanes *CellOperatorOf<dim, n_components>::state(Work &work) const
{
  const Lanes *gradients = work.unit.begin_gradients();
  if (slopes_are_in_order && !has_values)
    return gradients;
  for (unsigned int k = 0; k < place_of_slope.size(); ++k)
    work.state[k] = gradients[place_of_slope[k]];
  if (has_values)
    std::copy_n(work.unit.begin_values(), n_components * n_points, &work.state[place_of_slope.size()]);
  return work.state.data();
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::submit(Work &work, const bool with_values) const
{
  Lanes *gradients = work.unit.begin_gradients();
  for (unsigned int k = 0; k < place_of_slope.size(); ++k)
    gradients[place_of_slope[k]] = work.response[k];
  if (with_values)
    std::copy_n(&work.response[place_of_slope.size()], n_components * n_points, work.unit.begin_values());
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::read_geometry(Work &work) const
{
  work.is_cartesian = work.cell.get_cell_type() == GeometryType::cartesian;
  for (unsigned int q = 0; q < n_points; ++q) {
    const dealii::Tensor<2, dim, Lanes> J = work.cell.inverse_jacobian(q);
    const Lanes JxW = work.cell.JxW(q);
    for (unsigned int j = 0; j < dim; ++j)
      for (unsigned int l = 0; l < dim; ++l) {
        work.J[(j * dim + l) * n_points + q] = J[j][l];
        work.JxW_J[(j * dim + l) * n_points + q] = JxW * J[j][l];
      }
    work.J[dim * dim * n_points + q] = 1.;
    work.JxW_J[dim * dim * n_points + q] = JxW;
  }
}

/// From the unknowns in work.unit to the products with its functions, there as well.
template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::multiply_at_points(Work &work, const unsigned int batch,
                                                           const bool of_symmetric_part) const
{
  using Flags = dealii::EvaluationFlags::EvaluationFlags;
  const auto flags = [](const bool with_values) -> Flags {
    return with_values ? dealii::EvaluationFlags::values | dealii::EvaluationFlags::gradients
                       : dealii::EvaluationFlags::gradients;
  };
  const std::vector<PointTerm> &terms = of_symmetric_part ? symmetric_product : product;
  const std::size_t n = n_points * Lanes::size();
  const auto add = [n](const std::vector<PointTerm> &list, const Lanes *A, const Lanes *x, Array &y) {
    add_at_points(list, n, &A[0][0], &x[0][0], &y[0][0]);
  };
  work.unit.evaluate(flags(has_values));
  std::fill(work.response.begin(), work.response.end(), Lanes());
  if (is_uniform) {
    std::fill(work.in_space.begin(), work.in_space.end(), Lanes());
    std::fill(work.flux_in_space.begin(), work.flux_in_space.end(), Lanes());
    add(to_space[work.is_cartesian], work.JxW_J.data(), state(work), work.in_space);
    add(terms, tangents.data(), work.in_space.data(), work.flux_in_space);
    add(from_space[work.is_cartesian], work.J.data(), work.flux_in_space.data(), work.response);
  } else
    add(terms, &tangents[std::size_t(batch) * n_entries * n_points], state(work), work.response);
  const bool tests_values = has_sources || (has_values && of_symmetric_part);
  submit(work, tests_values);
  work.unit.integrate(flags(tests_values));
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::add_product(const double *x, double *y,
                                                    const bool of_symmetric_part) const
{
  Work work(*this);
  const unsigned int n_local = n_components * n_nodes;
  Lanes *local = work.unit.begin_dof_values();
  for (unsigned int batch = 0; batch < cells->matrix_free.n_cell_batches(); ++batch) {
    start(work, batch);
    const int *of_batch = index->data() + std::size_t(batch) * Lanes::size() * n_local;
    for (unsigned int lane = 0; lane < Lanes::size(); ++lane)
      for (unsigned int i = 0; i < n_local; ++i) {
        const int k = of_batch[lane * n_local + i];
        local[i][lane] = k < 0 ? 0. : x[k];
      }
    multiply_at_points(work, batch, of_symmetric_part);
    for (unsigned int lane = 0; lane < Lanes::size(); ++lane)
      for (unsigned int i = 0; i < n_local; ++i)
        if (const int k = of_batch[lane * n_local + i]; k >= 0)
          y[k] += local[i][lane];
  }
}

/// grad phi . A grad phi + grad phi . (V + W) phi + M phi^2 of the same component.
template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::add_diagonal(double *diagonal) const
{
  const dealii::Quadrature<dim> rule = domain.cell_quadrature();
  std::vector<dealii::Tensor<1, dim>> gradients;
  std::vector<double> values;
  for (unsigned int q = 0; q < n_points; ++q)
    for (unsigned int a = 0; a < n_nodes; ++a) {
      gradients.push_back(domain.scalar_element().shape_grad(hierarchic[a], rule.point(q)));
      values.push_back(domain.scalar_element().shape_value(hierarchic[a], rule.point(q)));
    }
  Evaluation cell(cells->matrix_free);
  std::vector<Lanes> sums(n_components * n_nodes), T(n_entries);
  for (unsigned int batch = 0; batch < cells->matrix_free.n_cell_batches(); ++batch) {
    cell.reinit(batch);
    const bool is_affine = cell.get_cell_type() <= GeometryType::affine;
    std::fill(sums.begin(), sums.end(), Lanes());
    for (unsigned int q = 0; q < n_points; ++q) {
      const Lanes weight = is_uniform && is_affine ? cell.JxW(q) / cell.JxW(0) : Lanes(1.);
      if (is_uniform && (q == 0 || !is_affine))
        refer_to_unit_cell(cell, q, tangents.data(), T);
      else if (!is_uniform)
        for (unsigned int e = 0; e < n_entries; ++e)
          T[e] = tangents[(std::size_t(batch) * n_entries + e) * n_points + q];
      for (unsigned int c = 0; c < n_components; ++c)
        for (unsigned int a = 0; a < n_nodes; ++a) {
          const dealii::Tensor<1, dim> &g = gradients[q * n_nodes + a];
          const double phi_a = values[q * n_nodes + a];
          Lanes sum = has_values ? T[at(n_slopes + c, n_slopes + c)] * phi_a * phi_a : Lanes();
          for (unsigned int j = 0; j < dim; ++j) {
            Lanes row = T[at(c * dim + j, c * dim)] * g[0];
            for (unsigned int l = 1; l < dim; ++l)
              row += T[at(c * dim + j, c * dim + l)] * g[l];
            if (has_values)
              row += (T[at(c * dim + j, n_slopes + c)] + T[at(n_slopes + c, c * dim + j)]) * phi_a;
            sum += row * g[j];
          }
          sums[c * n_nodes + a] += weight * sum;
        }
    }
    const int *of_batch = index->data() + std::size_t(batch) * Lanes::size() * sums.size();
    for (unsigned int lane = 0; lane < Lanes::size(); ++lane)
      for (unsigned int i = 0; i < sums.size(); ++i)
        if (const int k = of_batch[lane * sums.size() + i]; k >= 0)
          diagonal[k] += sums[i][lane];
  }
}

/// What multiply_at_points needs in a batch of cells.
template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::start(Work &work, const unsigned int batch) const
{
  if (is_uniform) {
    work.cell.reinit(batch);
    read_geometry(work);
  }
}

/// The part of P in one cell, by column.
struct LocalProlongation
{
  struct Entry
  {
    unsigned int column, row;
    double weight;
  };
  std::vector<int> columns; ///< of P
  std::vector<Entry> entries;
  std::vector<unsigned int> first_entry; ///< of each column, and one behind the last

  /// @p index of the @p n unknowns of the cell
  template <typename Prolongation>
  void reinit(const Prolongation &P, const int *index, unsigned int n);
};

template <typename Prolongation>
void LocalProlongation::reinit(const Prolongation &P, const int *index, const unsigned int n)
{
  columns.clear();
  entries.clear();
  for (unsigned int i = 0; i < n; ++i) {
    const auto row = P(index[i]);
    columns.insert(columns.end(), row.columns, row.columns + row.n);
  }
  std::sort(columns.begin(), columns.end());
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  for (unsigned int i = 0; i < n; ++i) {
    const auto row = P(index[i]);
    for (int k = 0; k < row.n; ++k) {
      const auto place = std::lower_bound(columns.begin(), columns.end(), row.columns[k]);
      entries.push_back({static_cast<unsigned int>(place - columns.begin()), i, row.weights[k]});
    }
  }
  std::stable_sort(entries.begin(), entries.end(),
                   [](const Entry &a, const Entry &b) { return a.column < b.column; });
  first_entry.assign(columns.size() + 1, entries.size());
  for (unsigned int e = entries.size(); e-- > 0;)
    first_entry[entries[e].column] = e;
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::for_each_cell(
    const typename CellOperator<dim>::Prolongation &P,
    const std::function<void(const std::vector<int> &columns)> &visit) const
{
  LocalProlongation local;
  for (unsigned int slot = 0; slot < cells->n_slots(); ++slot)
    if (cells->is_filled(slot)) {
      const unsigned int n_local = n_components * n_nodes;
      local.reinit(P, index->data() + std::size_t(slot) * n_local, n_local);
      visit(local.columns);
    }
}

template <int dim, int n_components>
void CellOperatorOf<dim, n_components>::for_each_restriction(
    const typename CellOperator<dim>::Prolongation &P,
    const typename CellOperator<dim>::VisitCell &visit) const
{
  Work work(*this);
  const unsigned int n_local = n_components * n_nodes;
  std::array<LocalProlongation, Lanes::size()> local_P;
  std::array<dealii::FullMatrix<double>, Lanes::size()> products;
  for (unsigned int batch = 0; batch < cells->matrix_free.n_cell_batches(); ++batch) {
    start(work, batch);
    const unsigned int n_filled = cells->matrix_free.n_active_entries_per_cell_batch(batch);
    unsigned int n_columns = 0;
    for (unsigned int lane = 0; lane < n_filled; ++lane) {
      local_P[lane].reinit(P, index->data() + (std::size_t(batch) * Lanes::size() + lane) * n_local, n_local);
      n_columns = std::max<unsigned int>(n_columns, local_P[lane].columns.size());
      products[lane].reinit(local_P[lane].columns.size(), local_P[lane].columns.size());
    }
    Lanes *local = work.unit.begin_dof_values();
    for (unsigned int column = 0; column < n_columns; ++column) {
      std::fill(local, local + n_local, Lanes());
      for (unsigned int lane = 0; lane < n_filled; ++lane)
        if (const LocalProlongation &own = local_P[lane]; column < own.columns.size())
          for (unsigned int e = own.first_entry[column]; e < own.first_entry[column + 1]; ++e)
            local[own.entries[e].row][lane] = own.entries[e].weight;
      multiply_at_points(work, batch, true);
      for (unsigned int lane = 0; lane < n_filled; ++lane)
        if (column < local_P[lane].columns.size())
          for (const auto &entry : local_P[lane].entries)
            products[lane](entry.column, column) += entry.weight * local[entry.row][lane];
    }
    for (unsigned int lane = 0; lane < n_filled; ++lane)
      visit(local_P[lane].columns, products[lane]);
  }
}

} // namespace

template <int dim>
std::string CellOperator<dim>::objection(const Domain<dim> &domain, const Field &field)
{
  if (domain.has_simplices())
    return "the domain " + domain.name + " has " + (dim == 2 ? "triangles" : "tetrahedra");
  if (domain.degree < 2)
    return "the domain " + domain.name + " has degree 1, where a matrix is faster";
  if (!field.is_continuous || field.relative_degree != 0 ||
      (field.n_components != 1 && field.n_components != dim))
    return "the element of the field is not that of the domain " + domain.name;
  return "";
}

template <int dim>
std::unique_ptr<CellOperator<dim>> CellOperator<dim>::make(const Domain<dim> &domain, const Field &field)
{
  if (field.n_components == 1)
    return std::make_unique<CellOperatorOf<dim, 1>>(domain, field);
  return std::make_unique<CellOperatorOf<dim, dim>>(domain, field);
}

template class CellOperator<2>;
template class CellOperator<3>;

} // namespace dovetail
