// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/interface/partner_shapes.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <map>

namespace dovetail {

namespace {

/// The points on one face, asked from the rank that owns it.
template <int dim>
struct Request
{
  unsigned int face;
  std::vector<unsigned int> points; ///< indices of the asking rank
  std::vector<dealii::Point<dim>> unit_points;
};

/// A list of requests as numbers: face, n points, coordinates …
template <int dim>
std::vector<double> pack(const std::vector<Request<dim>> &requests)
{
  std::vector<double> numbers;
  for (const auto &request : requests) {
    numbers.push_back(request.face);
    numbers.push_back(request.unit_points.size());
    for (const auto &point : request.unit_points)
      for (unsigned int d = 0; d < dim; ++d)
        numbers.push_back(point[d]);
  }
  return numbers;
}

template <int dim>
void append(const std::vector<dealii::Tensor<1, dim>> &gradients, std::vector<double> &numbers)
{
  for (const auto &gradient : gradients)
    for (unsigned int d = 0; d < dim; ++d)
      numbers.push_back(gradient[d]);
}

/// Answers as numbers: dofs, Omega, Gamma, the gradients at the centre, then values and gradients of each
/// point.
template <int dim>
std::vector<double> answer(const std::vector<double> &question, const Domain<dim> &domain,
                           const FaceLocator<dim> &locator, ShapeEvaluator<dim> &shapes)
{
  const unsigned int n_nodes = domain.n_nodes();
  std::vector<double> numbers, values(n_nodes);
  std::vector<dealii::Tensor<1, dim>> gradients(n_nodes);
  std::vector<dealii::types::global_dof_index> dofs;
  for (std::size_t i = 0; i < question.size();) {
    const auto &face = locator.side().faces[static_cast<unsigned int>(question[i++])];
    const unsigned int n_points = question[i++];
    shapes.reinit(face.cell);
    domain.cell_dofs(domain.dof_cell(face.cell), dofs);
    numbers.insert(numbers.end(), dofs.begin(), dofs.end());
    numbers.push_back(shapes.cell_measure(face.cell));
    numbers.push_back(shapes.face_measure(face.cell, face.face_no));
    if (domain.material.has_large_strain()) {
      shapes.evaluate(face.cell->reference_cell().template barycenter<dim>(), values.data(),
                      gradients.data());
      append(gradients, numbers);
    }
    for (unsigned int q = 0; q < n_points; ++q) {
      dealii::Point<dim> unit_point;
      for (unsigned int d = 0; d < dim; ++d)
        unit_point[d] = question[i++];
      shapes.evaluate(unit_point, values.data(), gradients.data());
      numbers.insert(numbers.end(), values.begin(), values.end());
      append(gradients, numbers);
    }
  }
  return numbers;
}

template <int dim>
void unpack(const unsigned int rank, const std::vector<double> &numbers,
            const std::vector<Request<dim>> &requests, const Domain<dim> &domain, PartnerShapes<dim> &result)
{
  const unsigned int n_nodes = domain.n_nodes();
  auto next = numbers.begin();
  const auto take_gradients = [&](dealii::Tensor<1, dim> *gradients) {
    for (unsigned int a = 0; a < n_nodes; ++a)
      for (unsigned int d = 0; d < dim; ++d)
        gradients[a][d] = *next++;
  };
  for (const auto &request : requests) {
    CellBehind<dim> cell;
    cell.dofs.assign(next, next + domain.dofs_per_cell());
    next += domain.dofs_per_cell();
    cell.cell_measure = *next++;
    cell.face_measure = *next++;
    if (domain.material.has_large_strain()) {
      cell.central_gradients.resize(n_nodes);
      take_gradients(cell.central_gradients.data());
    }
    cell.rank = rank;
    cell.face = request.face;
    for (const unsigned int point : request.points) {
      result.cell_of_point[point] = result.cells.size();
      std::copy(next, next + n_nodes, result.values.begin() + point * n_nodes);
      next += n_nodes;
      take_gradients(&result.gradients[point * n_nodes]);
    }
    result.cells.push_back(std::move(cell));
  }
}

} // namespace

template <int dim>
PartnerShapes<dim> fetch_shapes(const Domain<dim> &partner, const FaceLocator<dim> &locator,
                                const std::vector<typename FaceLocator<dim>::Match> &matches,
                                const MPI_Comm &communicator)
{
  PartnerShapes<dim> result;
  result.cell_of_point.assign(matches.size(), dealii::numbers::invalid_unsigned_int);
  result.values.resize(matches.size() * partner.n_nodes());
  result.gradients.resize(matches.size() * partner.n_nodes());

  std::map<unsigned int, std::vector<Request<dim>>> requests;
  std::map<std::pair<unsigned int, unsigned int>, unsigned int> request_of_face;
  for (unsigned int i = 0; i < matches.size(); ++i)
    if (matches[i].found) {
      auto &of_rank = requests[matches[i].rank];
      const auto [entry, is_new] =
          request_of_face.emplace(std::make_pair(matches[i].rank, matches[i].face), of_rank.size());
      if (is_new)
        of_rank.push_back({matches[i].face, {}, {}});
      of_rank[entry->second].points.push_back(i);
      of_rank[entry->second].unit_points.push_back(matches[i].unit_point);
    }

  ShapeEvaluator<dim> shapes(partner);
  const unsigned int this_rank = dealii::Utilities::MPI::this_mpi_process(communicator);
  if (const auto own = requests.find(this_rank); own != requests.end()) {
    unpack(this_rank, answer(pack(own->second), partner, locator, shapes), own->second, partner, result);
    requests.erase(own);
  }
  OfRanks questions, answers;
  for (const auto &[rank, of_rank] : requests) {
    questions[rank] = pack(of_rank);
    locator.work().faces += of_rank.size();
  }
  for (const auto &[rank, question] : exchange(questions, communicator, locator.work()))
    answers[rank] = answer(question, partner, locator, shapes);
  for (const auto &[rank, numbers] : exchange(answers, communicator, locator.work()))
    unpack(rank, numbers, requests.at(rank), partner, result);
  return result;
}

template PartnerShapes<2> fetch_shapes(const Domain<2> &, const FaceLocator<2> &,
                                       const std::vector<FaceLocator<2>::Match> &, const MPI_Comm &);
template PartnerShapes<3> fetch_shapes(const Domain<3> &, const FaceLocator<3> &,
                                       const std::vector<FaceLocator<3>::Match> &, const MPI_Comm &);

} // namespace dovetail
