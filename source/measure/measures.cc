// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_points.h>
#include <dovetail/domain/equal_cells.h>
#include <dovetail/domain/quadrature.h>
#include <dovetail/measure/flux_oscillation.h>
#include <dovetail/measure/gaps.h>
#include <dovetail/measure/interface_point.h>
#include <dovetail/measure/measures.h>
#include <dovetail/measure/uncovered_points.h>

#include <array>
#include <limits>
#include <optional>

namespace dovetail {

namespace {

using nlohmann::ordered_json;

/// The unknowns of a cell or of a group of points, from the vector of all.
void gather(const Vector &solution, const std::vector<dealii::types::global_dof_index> &dofs,
            std::vector<double> &unknowns)
{
  unknowns.resize(dofs.size());
  solution.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
}

double sum_over_ranks(const double value, const MPI_Comm &communicator)
{
  return dealii::Utilities::MPI::sum(value, communicator);
}

/// Squares of the L2 norms of error and exact solution, and of their gradients.
struct Squares
{
  double error = 0, error_of_gradient = 0, norm = 0, norm_of_gradient = 0;
};

/// Values and gradients of the exact solution at the points of a cell, by component of the domain.
template <int dim>
struct ExactSolution
{
  std::vector<std::vector<double>> value;
  std::vector<std::vector<dealii::Tensor<1, dim>>> gradient;

  void evaluate(const Domain<dim> &domain, const std::vector<dealii::Point<dim>> &X, const double t)
  {
    value.resize(domain.n_components());
    gradient.resize(domain.n_components());
    for (const Field &field : domain.fields())
      if (const Expression *exact = domain.exact().find(field.name))
        for (unsigned int c = 0; c < field.n_components; ++c) {
          exact->values(X, t, c, value[field.first_component + c]);
          exact->gradients(X, t, c, domain.typical_length(), gradient[field.first_component + c]);
        }
  }
};

/// The share of one point, for one field.
template <int dim>
void add_squares(const Domain<dim> &domain, const Field &field, const ExactSolution<dim> &exact,
                 const State<dim> &state, const dealii::FEValues<dim> &values, const unsigned int q,
                 Squares &squares)
{
  const double dV = domain.measure(values, q);
  for (unsigned int c = field.first_component; c < field.first_component + field.n_components; ++c) {
    const double B = exact.value[c][q], error = state.value[c] - B;
    const dealii::Tensor<1, dim> &gradient = exact.gradient[c][q], difference = state.gradient[c] - gradient;
    squares.norm += B * B * dV;
    squares.error += error * error * dV;
    squares.norm_of_gradient += (gradient * gradient) * dV;
    squares.error_of_gradient += (difference * difference) * dV;
  }
  if (domain.measure.has_hoop_strain(field)) { // u_r/r belongs to the gradient
    const double r = values.quadrature_point(q)[0], u = exact.value[field.first_component][q];
    squares.norm_of_gradient += std::pow(u / r, 2) * dV;
    squares.error_of_gradient += std::pow((state.value[field.first_component] - u) / r, 2) * dV;
  }
}

/// Integrals of (A_h - A).(grad B_h - grad B) and A.grad B, around an axis with P_33 u_r/r, for each field
/// that has an exact solution and whose flux depends on no field without.
template <int dim>
class EnergySquares
{
public:
  EnergySquares(const Domain<dim> &domain, const double t) : exact_point(domain, t)
  {
    const auto &fields = domain.fields();
    for (unsigned int f = 0; f < fields.size(); ++f) {
      bool is_known = true;
      for (unsigned int g = 0; g < fields.size(); ++g)
        if (domain.material.flux_depends(f, g) && domain.exact().find(fields[g].name) == nullptr)
          is_known = false;
      if (is_known)
        known.push_back({&fields[f], 0., 0.});
    }
  }

  struct Squares
  {
    const Field *field;
    double error, norm;
  };
  std::vector<Squares> known;

  void add_point(const dealii::FEValues<dim> &values, const unsigned int q, const ExactSolution<dim> &exact,
                 CellPoints<dim> &solution_point)
  {
    exact_point.state.X = solution_point.state.X;
    for (unsigned int i = 0; i < exact.value.size(); ++i)
      if (!exact.value[i].empty()) {
        exact_point.state.value[i] = exact.value[i][q];
        exact_point.state.gradient[i] = exact.gradient[i][q];
      }
    bool is_defined = solution_point.evaluate(false);
    is_defined = exact_point.evaluate(false) && is_defined;
    const double JxW =
        is_defined ? exact_point.domain.measure(values, q) : std::numeric_limits<double>::quiet_NaN();
    for (Squares &of_field : known)
      add(solution_point, JxW, of_field);
  }

private:
  void add(const CellPoints<dim> &solution_point, const double JxW, Squares &squares) const
  {
    const Field &field = *squares.field;
    for (unsigned int c = field.first_component; c < field.first_component + field.n_components; ++c) {
      const auto &exact_flux = exact_point.response.flux[c], &exact_gradient = exact_point.state.gradient[c];
      squares.error += (solution_point.response.flux[c] - exact_flux) *
                       (solution_point.state.gradient[c] - exact_gradient) * JxW;
      squares.norm += exact_flux * exact_gradient * JxW;
    }
    if (exact_point.domain.measure.has_hoop_strain(field)) {
      const unsigned int radial = field.first_component;
      const double S = exact_point.response.source[radial], u = exact_point.state.value[radial];
      squares.error +=
          (solution_point.response.source[radial] - S) * (solution_point.state.value[radial] - u) * JxW;
      squares.norm += S * u * JxW;
    }
  }

  CellPoints<dim> exact_point;
};

/// Adds "errors" and "norms" if the domain has an exact solution.
template <int dim>
void measure_errors(const Domain<dim> &domain, const Vector &solution, const double t, ordered_json &result)
{
  if (domain.exact().expressions.empty())
    return;
  const MPI_Comm communicator = solution.block(0).get_mpi_communicator();
  dealii::FEValues<dim> values(domain.mapping(), domain.layout().shape_element(),
                               gauss_rule<dim>(domain.cell_shape(), domain.degree + 3),
                               dealii::update_values | dealii::update_gradients |
                                   dealii::update_quadrature_points | dealii::update_JxW_values);
  const auto &fields = domain.fields();
  std::vector<Squares> squares(fields.size());
  ExactSolution<dim> exact;
  CellPoints<dim> point(domain, t);
  EnergySquares<dim> energy(domain, t);
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      values.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
      domain.cell_dofs(cell, dofs);
      gather(solution, dofs, unknowns);
      exact.evaluate(domain, values.get_quadrature_points(), t);
      point.enter(values, unknowns);
      for (const unsigned int q : values.quadrature_point_indices()) {
        point.go_to(q);
        for (unsigned int f = 0; f < fields.size(); ++f)
          if (!exact.value[fields[f].first_component].empty())
            add_squares(domain, fields[f], exact, point.state, values, q, squares[f]);
        if (!energy.known.empty())
          energy.add_point(values, q, exact, point);
      }
    }

  // coupled or at finite strain, the products of fluxes and gradients may be negative
  const auto norm = [&](const double square) {
    return std::sqrt(std::abs(sum_over_ranks(square, communicator)));
  };
  for (unsigned int f = 0; f < fields.size(); ++f)
    if (const std::string &field = fields[f].name; domain.exact().find(field) != nullptr) {
      result["errors"][field] = {{"L2", norm(squares[f].error)}, {"H1", norm(squares[f].error_of_gradient)}};
      result["norms"][field] = {{"L2", norm(squares[f].norm)}, {"H1", norm(squares[f].norm_of_gradient)}};
    }
  for (const auto &[field, error, magnitude] : energy.known) {
    result["errors"][field->name]["energy"] = norm(error);
    result["norms"][field->name]["energy"] = norm(magnitude);
  }
}

/// Whether the unknowns of a field are its values at the nodes.
template <int dim>
bool has_values_as_unknowns(const Domain<dim> &domain, const Field &field)
{
  return field.n_components == 1 && domain.layout().is_continuous(field.first_component);
}

/// Adds "maximum" and "minimum" of each field over the nodes, and of a scalar its "range", their difference.
template <int dim>
void measure_extremes(const Model<dim> &model, const Domain<dim> &domain, const Vector &solution,
                      ordered_json &result)
{
  const unsigned int n_fields = domain.fields().size();
  std::vector<double> largest(n_fields, -std::numeric_limits<double>::max()), minus_smallest = largest;
  std::vector<unsigned int> others;
  const auto &blocks = model.numbering->blocks();
  for (unsigned int b = 0; b < blocks.size(); ++b) {
    if (blocks[b].is_of_multipliers || model.domains[blocks[b].domain_index].get() != &domain)
      continue;
    const unsigned int f = blocks[b].field_index;
    if (has_values_as_unknowns(domain, domain.fields()[f])) {
      largest[f] = solution.block(b).max();
      minus_smallest[f] = -solution.block(b).min();
    } else
      others.push_back(f);
  }
  std::vector<dealii::types::global_dof_index> dofs;
  std::vector<double> unknowns, component_values, squares;
  const auto visit = [&](const auto &cell) {
    domain.cell_dofs(cell, dofs);
    gather(solution, dofs, unknowns);
    for (const unsigned int f : others) {
      const Field &field = domain.fields()[f];
      squares.clear();
      for (unsigned int c = 0; c < field.n_components; ++c) {
        domain.layout().nodal_values(field.first_component + c, unknowns, component_values);
        squares.resize(component_values.size(), 0.);
        for (unsigned int a = 0; a < squares.size(); ++a)
          squares[a] += component_values[a] * component_values[a];
      }
      for (unsigned int a = 0; a < squares.size(); ++a) {
        const double value = field.n_components == 1 ? component_values[a] : std::sqrt(squares[a]);
        largest[f] = std::max(largest[f], value);
        minus_smallest[f] = std::max(minus_smallest[f], -value);
      }
    }
  };
  if (!others.empty())
    for (const auto &cell : domain.dof_handler().active_cell_iterators())
      if (cell->is_locally_owned())
        visit(cell);
  const MPI_Comm communicator = solution.block(0).get_mpi_communicator();
  dealii::Utilities::MPI::max(largest, communicator, largest);
  dealii::Utilities::MPI::max(minus_smallest, communicator, minus_smallest);
  for (unsigned int f = 0; f < n_fields; ++f)
    result["maximum"][domain.fields()[f].name] = largest[f];
  for (unsigned int f = 0; f < n_fields; ++f)
    result["minimum"][domain.fields()[f].name] = -minus_smallest[f];
  for (unsigned int f = 0; f < n_fields; ++f)
    if (domain.fields()[f].n_components == 1)
      result["range"][domain.fields()[f].name] = largest[f] + minus_smallest[f];
}

template <int dim>
double volume(const Domain<dim> &domain, const MPI_Comm &communicator)
{
  dealii::FEValues<dim> values(domain.mapping(), domain.scalar_element(), domain.cell_quadrature(),
                               dealii::update_JxW_values | domain.measure.update_flags());
  EqualCells<dim> cells(domain.mapping());
  double sum = 0, of_cell = 0;
  for (const auto &cell : domain.mesh().active_cell_iterators())
    if (cell->is_locally_owned()) {
      if (domain.measure.is_axisymmetric() || !cells.is_equal(cell)) {
        values.reinit(cell);
        of_cell = 0;
        for (const unsigned int q : values.quadrature_point_indices())
          of_cell += domain.measure(values, q);
      }
      sum += of_cell;
    }
  return sum_over_ranks(sum, communicator);
}

/// Integrals over the points of an interface, of one field.
struct FluxIntegrals
{
  double jump = 0, flux_jump = 0, flux_error = 0, flux_norm = 0; // squares
  double largest_flux = 0, largest_flux_error = 0;               // squares
  std::array<double, 2> flux_gap = {{0, 0}}; // of the numerical flux from that of each side
  std::array<double, 2> flux_size = {{0, 0}};
  double numerical_flux = 0; // likewise squares
  std::array<std::vector<double>, 2> trace;

  template <int dim>
  void add(const typename InterfacePoint<dim>::FieldAtPoint &at_point, const double weight)
  {
    for (unsigned int c = 0; c < at_point.jump.size(); ++c) {
      for (const unsigned int side : {source, destination})
        trace[side][c] += at_point.trace[side][c] * weight;
      jump += at_point.jump[c] * at_point.jump[c] * weight;
      flux_jump += std::pow(at_point.flux[source][c] + at_point.flux[destination][c], 2) * weight;
      const double flux = at_point.numerical_flux[c];
      flux_gap[source] += std::pow(flux - at_point.flux[source][c], 2) * weight;
      flux_gap[destination] += std::pow(flux + at_point.flux[destination][c], 2) * weight;
      numerical_flux += flux * flux * weight;
    }
    for (const unsigned int side : {source, destination})
      flux_size[side] += std::pow(at_point.flux_size[side], 2) * weight;
  }

  /// @return the error of the numerical flux
  std::vector<double> add_error(const std::vector<double> &flux, const std::vector<double> &exact,
                                const double weight)
  {
    std::vector<double> error(exact.size());
    double square = 0, square_of_error = 0;
    for (unsigned int c = 0; c < exact.size(); ++c) {
      error[c] = flux[c] - exact[c];
      square += exact[c] * exact[c];
      square_of_error += error[c] * error[c];
    }
    flux_norm += square * weight;
    flux_error += square_of_error * weight;
    largest_flux = std::max(largest_flux, square);
    if (!(square_of_error <= largest_flux_error)) // not std::max(a, b), which drops NaN
      largest_flux_error = square_of_error;
    return error;
  }

  /// Collective.
  void report(const std::string &field, const double area, const bool knows_exact,
              const MPI_Comm &communicator, ordered_json &result)
  {
    const auto norm = [&](const double square) { return std::sqrt(sum_over_ranks(square, communicator)); };
    const auto largest = [&](const double square) {
      return std::sqrt(dealii::Utilities::MPI::max(square, communicator));
    };
    for (const unsigned int side : {source, destination}) {
      std::vector<double> &mean = trace[side];
      dealii::Utilities::MPI::sum(mean, communicator, mean);
      for (double &component : mean)
        component /= area;
      ordered_json &value = result[side == source ? "mean source" : "mean destination"][field];
      if (mean.size() == 1)
        value = mean[0];
      else
        value = mean;
    }
    result["jump L2"][field] = norm(jump);
    result["flux jump L2"][field] = norm(flux_jump);
    result["numerical flux L2"][field] = norm(numerical_flux);
    result["flux gap L2"][field] = std::fmin(norm(flux_gap[source]), norm(flux_gap[destination]));
    result["flux in bodies L2"][field] = std::fmin(norm(flux_size[source]), norm(flux_size[destination]));
    if (!knows_exact)
      return;
    result["flux error L2"][field] = norm(flux_error);
    result["flux norm L2"][field] = norm(flux_norm);
    result["flux error max"][field] = largest(largest_flux_error);
    result["flux max"][field] = largest(largest_flux);
  }
};

template <int dim>
void measure_fluxes(const Interface<dim> &interface, const Vector &solution, const double t,
                    ordered_json &result)
{
  InterfacePoint<dim> point(interface, t);
  std::vector<FluxIntegrals> integrals(interface.fields.size());
  std::vector<bool> is_known; // the exact flux, by field
  for (unsigned int f = 0; f < integrals.size(); ++f) {
    is_known.push_back(point.has_exact_flux(f));
    for (auto &side_trace : integrals[f].trace)
      side_trace.assign(interface.fields[f].n_components, 0.);
  }
  std::optional<FluxOscillation<dim>> oscillation;
  if (std::find(is_known.begin(), is_known.end(), true) != is_known.end())
    oscillation.emplace(interface);
  double area = 0;
  point.for_each(solution, [&](const unsigned int q, const unsigned int /*side_of_point*/) {
    const double weight = interface.pairing().weight(q);
    area += weight;
    for (unsigned int f = 0; f < integrals.size(); ++f) {
      const auto &field_numbers = point.fields[f];
      integrals[f].template add<dim>(field_numbers, weight);
      std::vector<double> error(field_numbers.jump.size(), 0.);
      if (is_known[f])
        error = integrals[f].add_error(field_numbers.numerical_flux, point.exact_flux(f, q), weight);
      if (oscillation)
        oscillation->add(f, q, error);
    }
  });

  const MPI_Comm communicator = solution.block(0).get_mpi_communicator();
  area = sum_over_ranks(area, communicator);
  const std::vector<double> oscillations =
      oscillation ? oscillation->evaluate(communicator) : std::vector<double>();
  for (unsigned int f = 0; f < integrals.size(); ++f) {
    const std::string &field = interface.fields[f].name;
    integrals[f].report(field, area, is_known[f], communicator, result);
    if (is_known[f])
      result["flux oscillation"][field] = oscillations[f];
  }
}

template <int dim>
void measure_penalty(const Interface<dim> &interface, const MPI_Comm &communicator, ordered_json &result)
{
  const PointTerms<dim> *terms = interface.tie().parts().point_terms;
  const PenaltyRange own = terms != nullptr ? terms->penalty() : PenaltyRange();
  const double smallest = dealii::Utilities::MPI::min(own.smallest, communicator);
  const double largest = dealii::Utilities::MPI::max(own.largest, communicator);
  const double margin = dealii::Utilities::MPI::min(own.coercivity_margin, communicator);
  if (largest > 0)
    result["penalty"] = {{"smallest", smallest}, {"largest", largest}};
  if (std::isfinite(margin))
    result["coercivity margin"] = margin;
  if (terms != nullptr) {
    const FluxVariations variations = terms->flux_variations();
    result["flux variations"] = {{"first", dealii::Utilities::MPI::sum(variations.first, communicator)},
                                 {"second", dealii::Utilities::MPI::sum(variations.second, communicator)}};
  }
}

/// Of what the tie remembers at the points: smallest, largest and integral over the interface.
template <int dim>
void measure_memory(const Interface<dim> &interface, const MPI_Comm &communicator, ordered_json &result)
{
  unsigned int i = 0;
  for (const InternalVariable &variable : interface.tie().internal_variables()) {
    double smallest = std::numeric_limits<double>::infinity(), largest = -smallest, integral = 0;
    for (unsigned int q = 0; q < interface.pairing().n_points(); ++q) {
      const double value = interface.memory.accepted(InterfaceMemory<dim>::joint, q)[i];
      smallest = std::min(smallest, value);
      largest = std::max(largest, value);
      integral += value * interface.pairing().weight(q);
    }
    result["internal variables"][variable.name] = {
        {"smallest", dealii::Utilities::MPI::min(smallest, communicator)},
        {"largest", dealii::Utilities::MPI::max(largest, communicator)},
        {"integral", sum_over_ranks(integral, communicator)}};
    i += variable.n_components;
  }
}

} // namespace

template <int dim>
ordered_json measure_domains(const Model<dim> &model, const Vector &solution, const double t)
{
  ordered_json all = ordered_json::object();
  for (const auto &domain : model.domains) {
    ordered_json result;
    result["cells"] = domain->mesh().n_global_active_cells();
    result["degree"] = domain->degree;
    result["dofs"] = domain->dof_handler().n_dofs();
    result["volume"] = volume(*domain, model.communicator);
    measure_errors(*domain, solution, t, result);
    measure_extremes(model, *domain, solution, result);
    all[domain->name] = result;
  }
  return all;
}

template <int dim>
ordered_json measure_interfaces(const Model<dim> &model, const Vector &solution,
                                const Reactions<dim> &reactions)
{
  ordered_json all = ordered_json::object();
  for (const auto &interface : model.interfaces) {
    ordered_json result;
    const Coverage &coverage = interface->pairing().coverage();
    result["area source"] = coverage.area[source];
    result["area destination"] = coverage.area[destination];
    result["covered source"] = coverage.covered[source];
    result["covered destination"] = coverage.covered[destination];
    result["uncovered points"] = coverage.n_uncovered;
    if (coverage.n_uncovered > 0)
      result["first uncovered points"] = list_uncovered_points(interface->pairing(), 100, model.communicator);
    const Gaps gaps = find_gaps(*interface, model.communicator);
    result["largest gap"] = gaps.largest_gap;
    result["largest overlap"] = gaps.largest_overlap;
    result["largest angle"] = coverage.largest_angle;
    if (coverage.n_segments > 0)
      result["segments"] = coverage.n_segments;
    result["points"] = coverage.n_points;
    measure_fluxes(*interface, solution, reactions.forces().t, result);
    for (const unsigned int side : {source, destination})
      for (unsigned int f = 0; f < interface->fields.size(); ++f)
        result[side == source ? "resultant source" : "resultant destination"][interface->fields[f].name] =
            reactions.interface_resultants(*interface, f)[side];
    measure_penalty(*interface, model.communicator, result);
    measure_memory(*interface, model.communicator, result);
    all[interface->name] = result;
  }
  return all;
}

template ordered_json measure_domains(const Model<2> &, const Vector &, double);
template ordered_json measure_domains(const Model<3> &, const Vector &, double);
template ordered_json measure_interfaces(const Model<2> &, const Vector &, const Reactions<2> &);
template ordered_json measure_interfaces(const Model<3> &, const Vector &, const Reactions<3> &);

} // namespace dovetail
