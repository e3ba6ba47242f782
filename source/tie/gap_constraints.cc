// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/tie/gap_constraints.h>

#include <cmath>
#include <set>

namespace dovetail {

namespace {

using Index = dealii::types::global_dof_index;

/// The sum of the weights of constrained unknowns in the gradient of one.
constexpr double largest_feedback = 0.5;
constexpr unsigned int n_sweeps = 2;

/// A destination unknown as its owner sees it.
struct Answer
{
  enum Kind { is_free, follows, is_led_by_another_tie } kind = is_free;
  GapLine line; ///< if it follows

  template <typename Archive>
  void serialize(Archive &archive, const unsigned int)
  {
    archive &kind &line.from_source &line.from_destination &line.offset;
  }
};

/// The answers of the owners, from their lines so far.
std::map<Index, Answer> ask(const RankMap<std::vector<Index>> &dofs_of_rank,
                            const std::map<Index, GapLine> &lines, const TieConstraints &constraints,
                            const MPI_Comm &communicator, InterfaceWork &work)
{
  RankMap<std::map<Index, Answer>> answers;
  for (const auto &[rank, dofs] : exchange(dofs_of_rank, communicator, work))
    for (const Index dof : dofs) {
      Answer &answer = answers[rank][dof];
      if (const auto line = lines.find(dof); line != lines.end())
        answer = {Answer::follows, line->second};
      else if (const auto other = constraints.lines.find(dof);
               other != constraints.lines.end() && !other->second.entries.empty())
        answer.kind = Answer::is_led_by_another_tie;
    }
  std::map<Index, Answer> result;
  for (auto &rank_part : exchange(std::move(answers), communicator, work))
    result.merge(rank_part.second);
  return result;
}

/// One equation, solved for its own unknown.
GapLine sweep(const Index own, const GapConstraint &constraint, const std::map<Index, Answer> &answers)
{
  double feedback = 0;
  for (const auto &[dof, weight] : constraint.wanted.from_destination) {
    const Answer &answer = answers.at(dof);
    if (answer.kind == Answer::is_led_by_another_tie)
      return constraint.first;
    feedback += answer.kind == Answer::follows ? std::abs(weight) : 0;
  }
  const double share = feedback > largest_feedback ? largest_feedback / feedback : 1;
  GapLine line;
  line.add(1 - share, constraint.first);
  line.offset += share * constraint.wanted.offset;
  double own_weight = 0;
  for (const auto &[dof, weight] : constraint.wanted.from_source)
    line.from_source[dof] += share * weight;
  for (const auto &[dof, weight] : constraint.wanted.from_destination)
    if (dof == own)
      own_weight = share * weight;
    else if (const Answer &answer = answers.at(dof); answer.kind == Answer::follows)
      line.add(share * weight, answer.line);
    else
      line.from_destination[dof] += share * weight;
  GapLine solved;
  solved.add(1 / (1 - own_weight), line);
  return solved;
}

} // namespace

void GapLine::add(const double factor, const GapLine &other)
{
  if (factor == 0)
    return;
  offset += factor * other.offset;
  for (const auto &[dof, weight] : other.from_source)
    from_source[dof] += factor * weight;
  for (const auto &[dof, weight] : other.from_destination)
    from_destination[dof] += factor * weight;
}

ConstraintLine GapLine::as_constraint() const
{
  std::map<Index, double> all = from_source; // sides of one body may share unknowns
  for (const auto &[dof, weight] : from_destination)
    all[dof] += weight;
  ConstraintLine line;
  line.entries.assign(all.begin(), all.end());
  line.inhomogeneity = offset;
  return line;
}

namespace {

double sum_of_weights(const std::map<Index, double> &weights)
{
  double sum = 0;
  for (const auto &entry : weights)
    sum += entry.second;
  return sum;
}

} // namespace

double GapLine::source_weight() const
{
  return sum_of_weights(from_source);
}

double GapLine::destination_weight() const
{
  return sum_of_weights(from_destination);
}

template <int dim>
std::map<Index, GapLine> gap_constraints(const std::map<Index, GapConstraint> &constrained,
                                         const Domain<dim> &destination, const TieConstraints &constraints,
                                         const MPI_Comm &communicator, InterfaceWork &work)
{
  std::map<Index, GapLine> lines;
  std::set<Index> asked;
  for (const auto &[own, constraint] : constrained) {
    lines[own] = constraint.first;
    for (const auto &entry : constraint.wanted.from_destination)
      asked.insert(entry.first);
  }
  if (dealii::Utilities::MPI::max(asked.size(), communicator) == 0)
    return lines;
  RankMap<std::vector<Index>> dofs_of_rank;
  for (const auto &[dof, rank] :
       owners(asked, destination.first_dof(), destination.dof_handler().locally_owned_dofs(), communicator))
    dofs_of_rank[rank].push_back(dof);
  for (unsigned int i = 0; i < n_sweeps; ++i) {
    const auto answers = ask(dofs_of_rank, lines, constraints, communicator, work);
    for (const auto &[own, constraint] : constrained)
      if (!constraint.wanted.from_destination.empty())
        lines[own] = sweep(own, constraint, answers);
  }
  return lines;
}

template std::map<Index, GapLine> gap_constraints(const std::map<Index, GapConstraint> &, const Domain<2> &,
                                                  const TieConstraints &, const MPI_Comm &, InterfaceWork &);
template std::map<Index, GapLine> gap_constraints(const std::map<Index, GapConstraint> &, const Domain<3> &,
                                                  const TieConstraints &, const MPI_Comm &, InterfaceWork &);

} // namespace dovetail
