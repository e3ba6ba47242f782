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

/// The cell behind a face, and its inverse Jacobians at the points.
template <int dim>
struct Answer
{
  CellBehind<dim> cell;
  std::vector<dealii::Tensor<2, dim>> inverse_jacobians;

  template <typename Archive>
  void serialize(Archive &archive, const unsigned int)
  {
    archive &cell &inverse_jacobians;
  }
};

template <int dim>
std::vector<Answer<dim>> answer(const std::vector<Request<dim>> &requests, const unsigned int this_rank,
                                const Domain<dim> &domain, const FaceLocator<dim> &locator,
                                const bool with_nodes, ShapeEvaluator<dim> &shapes)
{
  std::vector<Answer<dim>> answers;
  for (const Request<dim> &request : requests) {
    Answer<dim> answer{cell_behind(domain, locator.side(), request.face, this_rank, with_nodes, shapes), {}};
    for (const dealii::Point<dim> &point : request.unit_points)
      answer.inverse_jacobians.push_back(shapes.inverse_jacobian(point));
    answers.push_back(std::move(answer));
  }
  return answers;
}

} // namespace

template <int dim>
CellBehind<dim> cell_behind(const Domain<dim> &domain, const SideFaces<dim> &side, const unsigned int number,
                            const unsigned int this_rank, const bool with_nodes, ShapeEvaluator<dim> &shapes)
{
  const auto &face = side.faces[number];
  shapes.reinit(face.cell);
  CellBehind<dim> cell;
  domain.cell_dofs(domain.dof_cell(face.cell), cell.dofs);
  cell.cell_measure = shapes.cell_measure(face.cell);
  cell.face_measure = shapes.face_measure(face.cell, face.face_no);
  if (domain.material.has_large_strain()) {
    std::vector<double> unused(domain.layout().n_shapes());
    cell.central_gradients.resize(unused.size());
    shapes.evaluate(face.cell->reference_cell().template barycenter<dim>(), unused.data(),
                    cell.central_gradients.data());
  }
  cell.face_no = face.face_no;
  const bool has_nodes = with_nodes && !domain.has_simplices() && domain.degree > 1;
  for (unsigned int s = 0; has_nodes && s < domain.layout().n_spaces(); ++s) {
    const auto &element = domain.layout().element_of_space(s);
    for (unsigned int k = 0; k < element.n_dofs_per_cell(); ++k)
      cell.nodes.push_back(element.has_support_points() ? shapes.position(element.unit_support_point(k))
                                                        : dealii::Point<dim>());
  }
  cell.rank = this_rank;
  cell.face = number;
  return cell;
}

template <int dim>
PartnerShapes<dim> fetch_shapes(const Domain<dim> &partner, const FaceLocator<dim> &locator,
                                const std::vector<typename FaceLocator<dim>::Match> &matches,
                                const bool with_nodes, const MPI_Comm &communicator)
{
  PartnerShapes<dim> result;
  result.cell_of_point.assign(matches.size(), dealii::numbers::invalid_unsigned_int);
  result.inverse_jacobians.resize(matches.size());

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
  const unsigned int this_rank = dealii::Utilities::MPI::this_mpi_process(communicator);
  for (const auto &[rank, rank_requests] : requests)
    locator.work().faces += rank == this_rank ? 0 : rank_requests.size();

  ShapeEvaluator<dim> shapes(partner);
  RankMap<std::vector<Answer<dim>>> answers;
  for (const auto &[rank, rank_requests] : exchange(requests, communicator, locator.work()))
    answers[rank] = answer(rank_requests, this_rank, partner, locator, with_nodes, shapes);
  answers = exchange(std::move(answers), communicator, locator.work());
  const auto add = [&](const std::vector<Request<dim>> &asked, std::vector<Answer<dim>> &answered) {
    for (unsigned int k = 0; k < asked.size(); ++k) {
      for (unsigned int i = 0; i < asked[k].points.size(); ++i) {
        const unsigned int point = asked[k].points[i];
        result.cell_of_point[point] = result.cells.size();
        result.inverse_jacobians[point] = answered[k].inverse_jacobians[i];
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

template CellBehind<2> cell_behind(const Domain<2> &, const SideFaces<2> &, unsigned int, unsigned int, bool,
                                   ShapeEvaluator<2> &);
template PartnerShapes<2> fetch_shapes(const Domain<2> &, const FaceLocator<2> &,
                                       const std::vector<FaceLocator<2>::Match> &, bool, const MPI_Comm &);
template CellBehind<3> cell_behind(const Domain<3> &, const SideFaces<3> &, unsigned int, unsigned int, bool,
                                   ShapeEvaluator<3> &);
template PartnerShapes<3> fetch_shapes(const Domain<3> &, const FaceLocator<3> &,
                                       const std::vector<FaceLocator<3>::Match> &, bool, const MPI_Comm &);

} // namespace dovetail
