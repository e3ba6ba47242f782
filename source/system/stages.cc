// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/stages.h>

#include <algorithm>

namespace dovetail {

namespace {

/// That of a stage; a new one if there is none.
template <int dim>
typename Stages<dim>::Share &share_of(const unsigned int stage, typename Stages<dim>::Shares &shares)
{
  for (auto &share : shares)
    if (share.stage == stage)
      return share;
  shares.push_back({stage, {}, {}});
  return shares.back();
}

} // namespace

template <int dim>
void Stages<dim>::reinit(const bool are_coupled)
{
  stage_of_field = model.stages_of_fields();
  unsigned int n_stages = 1;
  for (auto &[field, stage] : stage_of_field) {
    stage = are_coupled ? 0 : stage;
    n_stages = std::max(n_stages, stage + 1);
  }
  stage_of_block.clear();
  for (const Block &block : model.numbering->blocks())
    stage_of_block.push_back(stage_of_field.at(block.field));
  asked_of_tangent.assign(n_stages, true);
  asked_of_residual = asked_of_tangent;
  shares.assign(model.domains.size(), {});
  for (unsigned int d = 0; d < model.domains.size(); ++d) {
    const auto &fields = model.domains[d]->fields();
    const CellLayout<dim> &layout = model.domains[d]->layout();
    for (unsigned int f = 0; f < fields.size(); ++f) {
      Share &share = share_of<dim>(stage_of_field.at(fields[f].name), shares[d]);
      share.fields.push_back(f);
      for (unsigned int i = layout.first(fields[f].first_component);
           i < layout.first(fields[f].first_component + fields[f].n_components); ++i)
        share.unknowns.push_back(i);
    }
  }
}

template <int dim>
bool Stages<dim>::is_left_out(const std::string &field, const std::string &by) const
{
  return stage_of_field.at(field) != stage_of_field.at(by);
}

template <int dim>
typename Stages<dim>::Shares
Stages<dim>::shares_of(const std::vector<dealii::types::global_dof_index> &dofs) const
{
  if (size() == 1)
    return {{0, {}, {}}};
  Shares result;
  for (unsigned int i = 0; i < dofs.size(); ++i)
    share_of<dim>(stage_of_block[model.numbering->block_of(dofs[i])], result).unknowns.push_back(i);
  return result;
}

template <int dim>
std::vector<bool> Stages<dim>::stages_of(const std::vector<bool> &blocks) const
{
  std::vector<bool> stages(size(), blocks.empty());
  for (unsigned int b = 0; b < blocks.size(); ++b)
    if (blocks[b])
      stages[stage_of_block[b]] = true;
  return stages;
}

template <int dim>
void Stages<dim>::ask_for(const std::vector<bool> &of_blocks, const std::vector<bool> &residual_of)
{
  asked_of_tangent = stages_of(of_blocks);
  asked_of_residual = stages_of(residual_of);
}

template <int dim>
bool Stages<dim>::asks_all_residuals() const
{
  return std::find(asked_of_residual.begin(), asked_of_residual.end(), false) == asked_of_residual.end();
}

template <int dim>
Asked Stages<dim>::what_is_asked(const std::string &field) const
{
  const unsigned int stage = stage_of_field.at(field);
  return !asked_of_residual[stage] ? Asked::nothing
         : asked_of_tangent[stage] ? Asked::derivatives
                                   : Asked::response;
}

template class Stages<2>;
template class Stages<3>;

} // namespace dovetail
