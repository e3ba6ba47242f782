// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// clang and gcc give different symbols to a function template whose return type looks a name up in a class of
// namespace std, as enable_if<is_same<…>::value> does: clang writes "sr3std…", gcc "srSt…". A program
// compiled by clang does therefore not find three functions of a deal.II compiled by gcc. Here the names
// of clang jump to those of gcc; both are weak, so that nothing happens where deal.II has the names of clang.

#define JUMP(from, to)                                                                                       \
  __asm__(".text\n.weak " #to "\n.weak " #from "\n.type " #from ", @function\n" #from ":\n  jmp " #to        \
          "@PLT\n")

// SparseMatrix::vmult<MPI::Vector>
JUMP(
    _ZNK6dealii16TrilinosWrappers12SparseMatrix5vmultINS0_3MPI6VectorEEENSt9enable_ifIXsr3std7is_sameINT_10value_typeEdEE5valueEvE4typeERS6_RKS6_,
    _ZNK6dealii16TrilinosWrappers12SparseMatrix5vmultINS0_3MPI6VectorEEENSt9enable_ifIXsrSt7is_sameINT_10value_typeEdE5valueEvE4typeERS7_RKS7_);
// SparseMatrix::reinit<DynamicSparsityPattern>
JUMP(
    _ZN6dealii16TrilinosWrappers12SparseMatrix6reinitINS_22DynamicSparsityPatternEEENSt9enable_ifIXntsr3std7is_sameIT_NS_12SparseMatrixIdEEEE5valueEvE4typeERKNS_8IndexSetESC_RKS5_RKP19ompi_communicator_tb,
    _ZN6dealii16TrilinosWrappers12SparseMatrix6reinitINS_22DynamicSparsityPatternEEENSt9enable_ifIXntsrSt7is_sameIT_NS_12SparseMatrixIdEEE5valueEvE4typeERKNS_8IndexSetESE_RKS6_RKP19ompi_communicator_tb);
// the same, from deal.II 9.5 on, which takes the communicator by value
JUMP(
    _ZN6dealii16TrilinosWrappers12SparseMatrix6reinitINS_22DynamicSparsityPatternEEENSt9enable_ifIXntsr3std7is_sameIT_NS_12SparseMatrixIdEEEE5valueEvE4typeERKNS_8IndexSetESC_RKS5_P19ompi_communicator_tb,
    _ZN6dealii16TrilinosWrappers12SparseMatrix6reinitINS_22DynamicSparsityPatternEEENSt9enable_ifIXntsrSt7is_sameIT_NS_12SparseMatrixIdEEE5valueEvE4typeERKNS_8IndexSetESE_RKS6_P19ompi_communicator_tb);
// eigenvectors<3, double>
JUMP(
    _ZN6dealii12eigenvectorsILi3EdEESt5arrayISt4pairIT0_NS_6TensorILi1EXT_ES3_EEEXsr3std17integral_constantIiXT_EEE5valueEERKNS_15SymmetricTensorILi2EXT_ES3_EENS_32SymmetricTensorEigenvectorMethodE,
    _ZN6dealii12eigenvectorsILi3EdEESt5arrayISt4pairIT0_NS_6TensorILi1EXT_ES3_EEEXsrSt17integral_constantIiXT_EE5valueEERKNS_15SymmetricTensorILi2EXT_ES3_EENS_32SymmetricTensorEigenvectorMethodE);
