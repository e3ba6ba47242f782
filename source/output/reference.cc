// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/shapes.h>
#include <dovetail/measure/cell_search.h>
#include <dovetail/measure/interface_point.h>
#include <dovetail/output/reference.h>

#include <deal.II/numerics/rtree.h>

#include <iterator>
#include <limits>

namespace dovetail {

using nlohmann::ordered_json;

namespace {

/// Points that are looked for at a time: what every rank holds of the file.
constexpr unsigned long chunk = 100000;

template <int dim>
dealii::Point<dim> point_of(const double *numbers)
{
  dealii::Point<dim> X;
  for (unsigned int d = 0; d < dim; ++d)
    X[d] = numbers[d];
  return X;
}

/// The places of the points that this rank shall evaluate: the nearest cell over all ranks, the first rank of
/// several. Collective.
template <int dim>
std::vector<typename CellSearch<dim>::Place>
share_points(const CellSearch<dim> &search, const std::vector<double> &numbers, const unsigned int per_point,
             const MPI_Comm &communicator)
{
  using Place = typename CellSearch<dim>::Place;
  std::vector<Place> places;
  std::vector<double> distances;
  for (std::size_t k = 0; k < numbers.size(); k += per_point) {
    places.push_back(search.find(point_of<dim>(&numbers[k])));
    distances.push_back(places.back().distance);
  }
  if (dealii::Utilities::MPI::n_mpi_processes(communicator) == 1)
    return places;
  std::vector<double> least(distances.size());
  dealii::Utilities::MPI::min(distances, communicator, least);
  const unsigned int rank = dealii::Utilities::MPI::this_mpi_process(communicator);
  std::vector<unsigned int> winners(places.size(), std::numeric_limits<unsigned int>::max());
  for (std::size_t k = 0; k < places.size(); ++k)
    if (places[k].cell != Place::nowhere && distances[k] <= least[k] + 1e-9)
      winners[k] = rank;
  dealii::Utilities::MPI::min(winners, communicator, winners);
  for (std::size_t k = 0; k < places.size(); ++k)
    if (winners[k] != rank)
      places[k] = Place();
  return places;
}

/// Squares of the L2 norms of error and reference, and of their gradients, by field.
struct SquaresOfField
{
  double error = 0, error_of_gradient = 0, norm = 0, norm_of_gradient = 0;
};

/// A point of this rank: its cell, and its place in the list of numbers.
struct Task
{
  unsigned int cell;
  std::size_t k;
  bool operator<(const Task &other) const { return std::tie(cell, k) < std::tie(other.cell, other.k); }
};

/// For all points of one cell, with the unknowns of the cell.
template <int dim>
void add_squares(const Domain<dim> &domain, const std::vector<double> &unknowns,
                 const std::vector<double> &values, const std::vector<dealii::Tensor<1, dim>> &gradients,
                 const double *sample, std::vector<SquaresOfField> &squares)
{
  const unsigned int n = domain.n_nodes();
  const double weight = sample[dim];
  for (unsigned int f = 0; f < domain.fields().size(); ++f) {
    const Field &field = domain.fields()[f];
    for (unsigned int c = field.first_component; c < field.first_component + field.n_components; ++c) {
      const double *component_sample = sample + dim + 1 + c * (1 + dim);
      double error = -component_sample[0];
      dealii::Tensor<1, dim> gradient;
      for (unsigned int d = 0; d < dim; ++d)
        gradient[d] = -component_sample[1 + d];
      squares[f].norm += weight * error * error;
      squares[f].norm_of_gradient += weight * gradient.norm_square();
      for (unsigned int a = 0; a < n; ++a) {
        error += unknowns[c * n + a] * values[a];
        gradient += unknowns[c * n + a] * gradients[a];
      }
      squares[f].error += weight * error * error;
      squares[f].error_of_gradient += weight * gradient.norm_square();
    }
  }
}

/// Values at scattered points, between them by an affine fit to the nearest ones.
template <int dim>
class Scattered
{
public:
  /// @p numbers: per point X, weight and values.
  Scattered(std::vector<double> numbers, const unsigned int per_point)
      : numbers(std::move(numbers)), per_point(per_point)
  {
    std::vector<Leaf> points;
    for (std::size_t k = 0; k < this->numbers.size(); k += per_point)
      points.emplace_back(point_of<dim>(&this->numbers[k]), k);
    tree = dealii::pack_rtree(points);
  }

  /// Least squares in coordinates scaled by the largest distance; a direction in which the points do not
  /// differ has no slope.
  std::vector<double> value(const dealii::Point<dim> &X) const
  {
    constexpr unsigned int n = dim + 1;
    std::vector<Leaf> nearest;
    tree.query(boost::geometry::index::nearest(X, dim == 2 ? 3 : 6), std::back_inserter(nearest));
    double size = 0;
    for (const Leaf &leaf : nearest)
      size = std::max(size, X.distance(leaf.first));
    dealii::FullMatrix<double> moments(n);
    dealii::FullMatrix<double> sums(n, per_point - n);
    for (const Leaf &leaf : nearest) {
      double basis[n] = {1};
      for (unsigned int d = 0; d < dim; ++d)
        basis[1 + d] = size > 0 ? (leaf.first[d] - X[d]) / size : 0.;
      for (unsigned int i = 0; i < n; ++i) {
        for (unsigned int j = 0; j < n; ++j)
          moments(i, j) += basis[i] * basis[j];
        for (unsigned int v = 0; v < per_point - n; ++v)
          sums(i, v) += basis[i] * numbers[leaf.second + n + v];
      }
    }
    for (unsigned int i = 1; i < n; ++i)
      moments(i, i) += 1e-9;
    moments.gauss_jordan();
    std::vector<double> values(per_point - n);
    for (unsigned int v = 0; v < values.size(); ++v)
      for (unsigned int j = 0; j < n; ++j)
        values[v] += moments(0, j) * sums(j, v);
    return values;
  }

private:
  using Leaf = std::pair<dealii::Point<dim>, std::size_t>;
  std::vector<double> numbers;
  unsigned int per_point;
  dealii::RTree<Leaf> tree;
};

template <typename Fields>
bool has_fields(const Samples::Part &part, const Fields &fields)
{
  if (part.fields.size() != fields.size())
    return false;
  for (unsigned int f = 0; f < fields.size(); ++f)
    if (part.fields[f] != std::pair<std::string, unsigned int>(fields[f].name, fields[f].n_components))
      return false;
  return true;
}

} // namespace

template <int dim>
Reference<dim>::Reference(const Section &output, const Model<dim> &model)
    : model(model),
      samples_file(output.read<std::string>(
          "Samples", "",
          "A file to which the solution at many points is written, for the Reference of other runs [-]")),
      reference_file(output.read<std::string>(
          "Reference", "",
          "The Samples of another run; errors are measured against these samples instead of Exact [-]"))
{
  if (output.documenting())
    return;
  if (!samples_file.empty()) {
    const std::string obstacle = obstacle_to_samples(samples_file, reference_file, model.communicator);
    output.check(obstacle.empty(), "Samples",
                 "is '" + samples_file + "', but cannot be written. " + obstacle + " Choose another file.");
  }
  if (reference_file.empty())
    return;
  try {
    reference = read_samples(reference_file, dim, model.communicator);
  } catch (const UserError &error) {
    output.fail("Reference", "is '" + reference_file + "', which " + error.what());
  }
  check_fields(output);
}

template <int dim>
void Reference<dim>::check_fields(const Section &output) const
{
  for (const auto &domain : model.domains) {
    const Samples::Part *part = Samples::find(reference->domains, domain->name);
    std::vector<std::string> known;
    for (const auto &other : reference->domains)
      known.push_back(other.name);
    output.check(part != nullptr, "Reference",
                 "is '" + reference_file + "', which has no domain '" + domain->name + "' but " +
                     comma_separated(known) + ". " + did_you_mean(domain->name, known));
    output.check(has_fields(*part, domain->fields()), "Reference",
                 "is '" + reference_file + "', in which the domain '" + domain->name +
                     "' has other fields. Make it anew with these materials.");
  }
}

template <int dim>
void Reference<dim>::compare(const Vector &solution, const double t, const bool is_converged,
                             ordered_json &domains, ordered_json &interfaces) const
{
  if (!samples_file.empty() && is_converged)
    write_samples(model, solution, t, samples_file);
  if (!reference)
    return;
  for (const auto &domain : model.domains)
    compare_domain(*domain, *Samples::find(reference->domains, domain->name), solution,
                   domains[domain->name]);
  for (const auto &interface : model.interfaces) {
    ordered_json &result = interfaces[interface->name];
    for (const char *exact_key :
         {"flux error L2", "flux norm L2", "flux error max", "flux max", "flux oscillation"})
      result.erase(exact_key);
    const Samples::Part *part = Samples::find(reference->interfaces, interface->name);
    if (part == nullptr || part->n_points == 0 || !has_fields(*part, interface->fields))
      continue;
    const std::string source_words = side_in_words(interface->sides[source]),
                      destination_words = side_in_words(interface->sides[destination]);
    if (part->source == source_words && part->destination == destination_words)
      compare_interface(*interface, *part, 1., solution, t, result);
    else if (part->source == destination_words && part->destination == source_words)
      compare_interface(*interface, *part, -1., solution, t, result);
  }
}

template <int dim>
void Reference<dim>::compare_domain(const Domain<dim> &domain, const Samples::Part &part,
                                    const Vector &solution, ordered_json &result) const
{
  const CellSearch<dim> search(domain);
  std::vector<SquaresOfField> squares(domain.fields().size());
  ShapeEvaluator<dim> shapes(domain);
  std::vector<double> values(domain.n_nodes()), unknowns;
  std::vector<dealii::Tensor<1, dim>> gradients(domain.n_nodes());
  std::vector<dealii::types::global_dof_index> dofs;
  double weight_found = 0, weight = 0;
  for (unsigned long begin = 0; begin < part.n_points; begin += chunk) {
    const auto numbers = read_points(reference_file, part, begin, std::min(begin + chunk, part.n_points));
    const auto places = share_points(search, numbers, part.n_numbers, model.communicator);
    std::vector<Task> tasks;
    for (std::size_t k = 0; k < places.size(); ++k) {
      weight += numbers[k * part.n_numbers + dim];
      if (places[k].cell != CellSearch<dim>::Place::nowhere) {
        tasks.push_back({places[k].cell, k});
        weight_found += numbers[k * part.n_numbers + dim];
      }
    }
    std::sort(tasks.begin(), tasks.end());
    unsigned int cell = CellSearch<dim>::Place::nowhere;
    for (const Task &task : tasks) {
      if (task.cell != cell) {
        cell = task.cell;
        shapes.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(search.cell(cell)));
        domain.cell_dofs(search.cell(cell), dofs);
        unknowns.resize(dofs.size());
        for (unsigned int i = 0; i < dofs.size(); ++i)
          unknowns[i] = solution(dofs[i]);
      }
      shapes.evaluate(places[task.k].unit_point, values.data(), gradients.data());
      add_squares(domain, unknowns, values, gradients, &numbers[task.k * part.n_numbers], squares);
    }
  }

  const auto norm = [&](const double square) {
    return std::sqrt(dealii::Utilities::MPI::sum(square, model.communicator));
  };
  result.erase("errors");
  result.erase("norms");
  for (unsigned int f = 0; f < squares.size(); ++f) {
    const std::string &name = domain.fields()[f].name;
    result["errors"][name] = {{"L2", norm(squares[f].error)}, {"H1", norm(squares[f].error_of_gradient)}};
    result["norms"][name] = {{"L2", norm(squares[f].norm)}, {"H1", norm(squares[f].norm_of_gradient)}};
  }
  weight_found = dealii::Utilities::MPI::sum(weight_found, model.communicator);
  result["reference points outside"] = weight > 0 ? std::max(0., 1 - weight_found / weight) : 0.;
}

template <int dim>
void Reference<dim>::compare_interface(const Interface<dim> &interface, const Samples::Part &part,
                                       const double sign, const Vector &solution, const double t,
                                       ordered_json &result) const
{
  const Scattered<dim> flux(read_points(reference_file, part, 0, part.n_points), part.n_numbers);
  std::vector<double> errors(interface.fields.size()), norms(errors);
  InterfacePoint<dim> point(interface, t);
  point.for_each(solution, [&](const unsigned int q, const unsigned int) {
    const double weight = interface.pairing().weight(q);
    const std::vector<double> exact = flux.value(interface.pairing().X(source, q));
    unsigned int component = 0;
    for (unsigned int f = 0; f < errors.size(); ++f)
      for (const double own : point.fields[f].numerical_flux) {
        errors[f] += weight * std::pow(own - sign * exact[component], 2);
        norms[f] += weight * std::pow(exact[component], 2);
        ++component;
      }
  });
  for (unsigned int f = 0; f < errors.size(); ++f) {
    const std::string &name = interface.fields[f].name;
    result["flux error L2"][name] = std::sqrt(dealii::Utilities::MPI::sum(errors[f], model.communicator));
    result["flux norm L2"][name] = std::sqrt(dealii::Utilities::MPI::sum(norms[f], model.communicator));
  }
}

template class Reference<2>;
template class Reference<3>;

} // namespace dovetail
