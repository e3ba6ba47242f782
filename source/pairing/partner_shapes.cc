// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/pairing/partner_shapes.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <map>

namespace dovetail {

namespace {

/// The points on one face, asked from the rank that owns it.
template <int dim>
struct Request
{
  unsigned int face = 0;
  std::vector<dealii::Point<dim>> unit_points;
  std::vector<unsigned int> points; ///< their indices on the asking rank, which are not sent

  template <typename Archive>
  void serialize(Archive &archive, const unsigned int)
  {
    archive &face &unit_points;
  }
};

/// The cell behind a face, and its shape functions at the points: point i has them at i * n_nodes.
template <int dim>
struct Answer
{
  CellBehind<dim> cell;
  std::vector<double> values;
  std::vector<dealii::Tensor<1, dim>> gradients;

  template <typename Archive>
  void serialize(Archive &archive, const unsigned int)
  {
    archive &cell &values &gradients;
  }
};

template <int dim>
std::vector<Answer<dim>> answer(const std::vector<Request<dim>> &requests, const unsigned int this_rank,
                                const Domain<dim> &domain, const FaceLocator<dim> &locator,
                                ShapeEvaluator<dim> &shapes)
{
  const unsigned int n_nodes = domain.n_nodes();
  std::vector<Answer<dim>> answers;
  std::vector<double> unused(n_nodes);
  for (const Request<dim> &request : requests) {
    const auto &face = locator.side().faces[request.face];
    shapes.reinit(face.cell);
    Answer<dim> answer;
    CellBehind<dim> &cell = answer.cell;
    domain.cell_dofs(domain.dof_cell(face.cell), cell.dofs);
    cell.cell_measure = shapes.cell_measure(face.cell);
    cell.face_measure = shapes.face_measure(face.cell, face.face_no);
    if (domain.material.has_large_strain()) {
      cell.central_gradients.resize(n_nodes);
      shapes.evaluate(face.cell->reference_cell().template barycenter<dim>(), unused.data(),
                      cell.central_gradients.data());
    }
    cell.rank = this_rank;
    cell.face = request.face;
    answer.values.resize(request.unit_points.size() * n_nodes);
    answer.gradients.resize(request.unit_points.size() * n_nodes);
    for (unsigned int i = 0; i < request.unit_points.size(); ++i)
      shapes.evaluate(request.unit_points[i], &answer.values[i * n_nodes], &answer.gradients[i * n_nodes]);
    answers.push_back(std::move(answer));
  }
  return answers;
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

  RankMap<std::vector<Request<dim>>> requests;
  std::map<std::pair<unsigned int, unsigned int>, unsigned int> request_of_face;
  for (unsigned int i = 0; i < matches.size(); ++i)
    if (matches[i].found) {
      auto &rank_requests = requests[matches[i].rank];
      const auto [entry, is_new] =
          request_of_face.emplace(std::make_pair(matches[i].rank, matches[i].face), rank_requests.size());
      if (is_new)
        rank_requests.push_back({matches[i].face, {}, {}});
      rank_requests[entry->second].unit_points.push_back(matches[i].unit_point);
      rank_requests[entry->second].points.push_back(i);
    }
  const unsigned int this_rank = dealii::Utilities::MPI::this_mpi_process(communicator),
                     n_nodes = partner.n_nodes();
  for (const auto &[rank, rank_requests] : requests)
    locator.work().faces += rank == this_rank ? 0 : rank_requests.size();

  ShapeEvaluator<dim> shapes(partner);
  RankMap<std::vector<Answer<dim>>> answers;
  for (const auto &[rank, rank_requests] : exchange(requests, communicator, locator.work()))
    answers[rank] = answer(rank_requests, this_rank, partner, locator, shapes);
  answers = exchange(std::move(answers), communicator, locator.work());
  const auto add = [&](const std::vector<Request<dim>> &asked, std::vector<Answer<dim>> &answered) {
    for (unsigned int k = 0; k < asked.size(); ++k) {
      for (unsigned int i = 0; i < asked[k].points.size(); ++i) {
        const unsigned int point = asked[k].points[i];
        result.cell_of_point[point] = result.cells.size();
        std::copy_n(&answered[k].values[i * n_nodes], n_nodes, &result.values[point * n_nodes]);
        std::copy_n(&answered[k].gradients[i * n_nodes], n_nodes, &result.gradients[point * n_nodes]);
      }
      result.cells.push_back(std::move(answered[k].cell));
    }
  };
  add(requests[this_rank], answers[this_rank]); // the cells of this rank come first
  requests.erase(this_rank);
  for (const auto &[rank, asked] : requests)
    add(asked, answers.at(rank));
  return result;
}

template PartnerShapes<2> fetch_shapes(const Domain<2> &, const FaceLocator<2> &,
                                       const std::vector<FaceLocator<2>::Match> &, const MPI_Comm &);
template PartnerShapes<3> fetch_shapes(const Domain<3> &, const FaceLocator<3> &,
                                       const std::vector<FaceLocator<3>::Match> &, const MPI_Comm &);

} // namespace dovetail
