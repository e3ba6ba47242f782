// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/kept_positions.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dovetail {

template <int dim>
KeptPositions<dim>::KeptPositions(const Domain<dim> &domain, const std::vector<unsigned int> &fields,
                                  const BlockMatrix &matrix)
    : matrix(matrix), n_cells(domain.mesh().n_active_cells())
{
  const CellLayout<dim> &layout = domain.layout();
  for (const unsigned int f : fields) {
    const Field &field = domain.fields()[f];
    const unsigned int n_nodes = layout.n_nodes(field.first_component);
    for (unsigned int a = 0; a < n_nodes; ++a) {
      nodes.emplace_back();
      for (unsigned int c = 0; c < field.n_components; ++c)
        nodes.back().push_back(n_local + c * n_nodes + a);
    }
    n_local += field.n_components * n_nodes;
  }
  const dealii::BlockIndices &indices = matrix.get_row_indices();
  const Index end = domain.first_dof() + domain.dof_handler().n_dofs();
  unsigned int field_of_block = 0;
  for (unsigned int b = 0; b < indices.size(); ++b)
    if (const Index begin = indices.block_start(b);
        begin >= domain.first_dof() && begin < end &&
        std::find(fields.begin(), fields.end(), field_of_block++) != fields.end()) {
      const RowNumbering &numbering = matrix.numbering(matrix.part_of(b));
      const auto &members = numbering.blocks();
      const unsigned int i = std::find(members.begin(), members.end(), b) - members.begin();
      const dealii::IndexSet &own = matrix.owned_unknowns()[b];
      AssertThrow(own.is_contiguous(), dealii::ExcInternalError());
      const Index begin_owned = begin + (own.n_elements() == 0 ? 0 : own.nth_index_in_set(0));
      blocks.push_back({begin, begin + indices.block_size(b), b, numbering.first_local_of(i), begin_owned,
                        begin_owned + own.n_elements()});
      has_one_part = has_one_part && matrix.part_of(b) == matrix.part_of(blocks[0].number);
    }
  part = matrix.part_of(blocks[0].number);
  const Epetra_CrsMatrix &entries = matrix.part(part, part).trilinos_matrix();
  for (int row = 0; row < entries.NumMyRows() && columns_are_rows; ++row)
    columns_are_rows = entries.LCID(entries.GRID(row)) == row;
  columns.resize(n_local);
  all_rows.resize(n_local);
  positions.resize(nodes.size() * nodes.size());
}

template <int dim>
void KeptPositions<dim>::keep()
{
  if (keeps)
    return;
  keeps = true;
  way.assign(n_cells, Way::unknown);
  all_rows.resize(n_cells * n_local);
  positions.resize(n_cells * nodes.size() * nodes.size());
}

template <int dim>
typename KeptPositions<dim>::Rows KeptPositions<dim>::rows() const
{
  Rows result;
  result.exist = matrix.part(part, part)
                     .trilinos_matrix()
                     .ExtractCrsDataPointers(result.first, result.columns, result.values) == 0;
  return result;
}

/// @return false if another rank owns one of the unknowns.
template <int dim>
bool KeptPositions<dim>::find_rows(const std::vector<Index> &dofs, int *row_of_dof, int *column_of_dof) const
{
  const Epetra_CrsMatrix &entries = matrix.part(part, part).trilinos_matrix();
  const BlockOfDofs *block = &blocks[0];
  for (unsigned int i = 0; i < n_local; ++i) {
    if (dofs[i] < block->begin || dofs[i] >= block->end)
      block = &*std::find_if(blocks.begin(), blocks.end(), [&](const BlockOfDofs &candidate) {
        return dofs[i] >= candidate.begin && dofs[i] < candidate.end;
      });
    if (dofs[i] < block->begin_owned || dofs[i] >= block->end_owned)
      return false;
    row_of_dof[i] = block->first_row + (dofs[i] - block->begin_owned);
    column_of_dof[i] = columns_are_rows ? row_of_dof[i] : entries.LCID(entries.GRID(row_of_dof[i]));
  }
  return true;
}

/// @return false if the positions do not have the form in which they are kept.
template <int dim>
bool KeptPositions<dim>::find(const std::vector<Index> &dofs, int *row_of_dof, std::uint16_t *kept)
{
  const Rows entries = rows();
  std::vector<int> &column_of_dof = columns;
  if (!has_one_part || !entries.exist || !find_rows(dofs, row_of_dof, column_of_dof.data()))
    return false;
  const bool are_scalars = nodes.size() == n_local;
  // whether the entries of all components of two nodes stand behind that of the first ones
  const auto has_all = [&](const auto &node, const auto &other, const int position) {
    const unsigned int n_rows = node.size(), n_columns = other.size();
    bool result = true;
    for (unsigned int k = 1; k < n_rows * n_columns && result; ++k) {
      const int row = row_of_dof[node[k / n_columns]], place = entries.first[row] + position + k % n_columns;
      result =
          place < entries.first[row + 1] && entries.columns[place] == column_of_dof[other[k % n_columns]];
    }
    return result;
  };
  for (const auto &node : nodes) {
    const int row = row_of_dof[node[0]];
    const int *const begin = entries.columns + entries.first[row], *const end = entries.columns +
                                                                                entries.first[row + 1];
    for (const auto &other : nodes) {
      const int column = column_of_dof[other[0]];
      std::ptrdiff_t position = *kept; // where it was in the cell before, perhaps
      if (position >= end - begin || begin[position] != column)
        position = std::lower_bound(begin, end, column) - begin;
      if (position >= end - begin || begin[position] != column ||
          position > std::numeric_limits<std::uint16_t>::max() ||
          !(are_scalars || has_all(node, other, position)))
        return false;
      *kept++ = position;
    }
  }
  return true;
}

namespace {

/// What a cell needs of the constraints.
struct Prescribed
{
  bool is_any, is_general; ///< an unknown of the cell; one that follows others or moves
  std::vector<char> is;    ///< by unknown

  void find(const std::vector<BlockMatrix::size_type> &dofs,
            const dealii::AffineConstraints<double> &constraints)
  {
    is_any = is_general = false;
    is.assign(dofs.size(), 0);
    for (unsigned int i = 0; i < dofs.size(); ++i)
      if (constraints.is_constrained(dofs[i])) {
        is[i] = 1;
        is_any = true;
        is_general = is_general || constraints.get_inhomogeneity(dofs[i]) != 0 ||
                     !constraints.get_constraint_entries(dofs[i])->empty();
      }
  }
};

/// Of the row of an unknown with the position of each node: all columns, where a vector is the only field.
template <int dim>
void add_row_of_vector(const unsigned int n_nodes, const std::uint16_t *const position,
                       const double *const from, double *const row)
{
  for (unsigned int b = 0; b < n_nodes; ++b) {
    double *const to = row + position[b];
    for (unsigned int k = 0; k < dim; ++k)
      to[k] += from[k * n_nodes + b];
  }
}

/// Likewise where all fields are scalars.
void add_row_of_scalars(const unsigned int n_nodes, const std::uint16_t *const position,
                        const double *const from, double *const row)
{
  for (unsigned int b = 0; b < n_nodes; ++b)
    row[position[b]] += from[b];
}

/// Likewise of any fields.
void add_row(const std::vector<std::vector<unsigned int>> &nodes, const std::uint16_t *position,
             const double *from, double *row)
{
  for (const auto &node : nodes) {
    double *to = row + *position++;
    for (const unsigned int j : node)
      *to++ += from[j];
  }
}

/// Likewise but for prescribed columns.
void add_row(const std::vector<std::vector<unsigned int>> &nodes, const std::uint16_t *position,
             const double *from, const Prescribed &prescribed, double *row)
{
  for (const auto &node : nodes) {
    double *const to = row + *position++;
    for (unsigned int k = 0; k < node.size(); ++k)
      if (const unsigned int j = node[k]; prescribed.is[j] == 0)
        to[k] += from[j];
  }
}

/// Of a prescribed row, as AffineConstraints has it: |K_ii|, or the mean of those where that is zero.
double diagonal_of_prescribed(const dealii::FullMatrix<double> &local_matrix, const unsigned int i)
{
  if (local_matrix(i, i) != 0)
    return std::abs(local_matrix(i, i));
  double sum = 0;
  for (unsigned int k = 0; k < local_matrix.m(); ++k)
    sum += std::abs(local_matrix(k, k));
  return sum / local_matrix.m();
}

} // namespace

template <int dim>
void KeptPositions<dim>::prefetch(const unsigned int cell_index) const
{
  constexpr std::size_t largest = 64 * 1024; // bytes that are still there after the cell
  if (!keeps || way[cell_index] != Way::kept || sizeof(double) * n_local * n_local > largest)
    return;
  const int *const row_of_dof = &all_rows[std::size_t(cell_index) * n_local];
  const std::uint16_t *kept = &positions[std::size_t(cell_index) * nodes.size() * nodes.size()];
  const Rows entries = rows();
  for (const auto &node : nodes) {
    for (const unsigned int i : node) {
      const double *const row = entries.values + entries.first[row_of_dof[i]];
      for (unsigned int b = 0; b < nodes.size(); ++b)
        __builtin_prefetch(row + kept[b], 1);
    }
    kept += nodes.size();
  }
}

template <int dim>
bool KeptPositions<dim>::add(const unsigned int cell_index, const std::vector<Index> &dofs,
                             const dealii::AffineConstraints<double> &constraints,
                             const dealii::FullMatrix<double> &local_matrix,
                             const std::vector<double> &local_residual, SharedSums &right_hand_side)
{
  thread_local Prescribed of_thread;
  thread_local std::vector<double> rest_of_thread;
  Prescribed &prescribed = of_thread;
  std::vector<double> &rest = rest_of_thread;
  prescribed.find(dofs, constraints);
  if (!keeps && prescribed.is_general)
    return false;
  const std::size_t place = keeps ? cell_index : 0;
  int *const row_of_dof = &all_rows[place * n_local];
  std::uint16_t *kept = &positions[place * nodes.size() * nodes.size()];
  Way known = keeps ? way[cell_index] : Way::unknown;
  if (known == Way::unknown)
    known = find(dofs, row_of_dof, kept) ? Way::kept : Way::general;
  if (keeps)
    way[cell_index] = known;
  if (known == Way::general || prescribed.is_general)
    return false;

  rest = local_residual;
  const Rows entries = rows();
  const bool is_vector = nodes[0].size() == dim && nodes.size() * dim == n_local,
             are_scalars = nodes.size() == n_local;
  for (unsigned int n = 0; n < nodes.size(); ++n, kept += nodes.size())
    for (unsigned int k = 0; k < nodes[n].size(); ++k) {
      const unsigned int i = nodes[n][k];
      double *const row = entries.values + entries.first[row_of_dof[i]];
      if (!prescribed.is_any && is_vector)
        add_row_of_vector<dim>(nodes.size(), kept, &local_matrix(i, 0), row);
      else if (!prescribed.is_any && are_scalars)
        add_row_of_scalars(nodes.size(), kept, &local_matrix(i, 0), row);
      else if (!prescribed.is_any)
        add_row(nodes, kept, &local_matrix(i, 0), row);
      else if (prescribed.is[i] == 0)
        add_row(nodes, kept, &local_matrix(i, 0), prescribed, row);
      else {
        row[kept[n] + k] += diagonal_of_prescribed(local_matrix, i);
        rest[i] = 0;
      }
    }
  for (const BlockOfDofs &block : blocks) {
    double *const values = right_hand_side.owned_rows(block.number) - block.first_row;
    for (unsigned int i = 0; i < n_local; ++i)
      if (dofs[i] >= block.begin && dofs[i] < block.end)
        values[row_of_dof[i]] -= rest[i];
  }
  return true;
}

template class KeptPositions<2>;
template class KeptPositions<3>;

} // namespace dovetail
