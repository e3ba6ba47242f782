/* SPDX-License-Identifier: LGPL-2.1-or-later
 * Copyright (C) 2026 by the Dovetail authors
 *
 * Counts what the ranks of a program send, by kind of call: a library that is loaded before MPI and stands between it and
 * the program (the profiling interface of MPI). At the end rank 0 prints the calls and the bytes of one rank, the mean and
 * the largest, for each kind.
 *
 *     mpicc -O2 -shared -fPIC messages.c -o messages.so
 *     mpirun -np 8 -x LD_PRELOAD=./messages.so dovetail scene.prm
 *
 * The bytes of a collective call are those that the rank gives and receives without any tree: an all-gather counts what
 * all ranks give, because each receives it.
 */

#include <mpi.h>
#include <stdio.h>
#include <string.h>

enum { sends, reductions, gathers, all_to_alls, broadcasts, barriers, scans, n_kinds };
static const char *const name[] = {"point to point", "all-reduce, reduce", "all-gather, gather", "all-to-all",
                                   "broadcast", "barrier", "scan"};
static double calls[n_kinds], bytes[n_kinds];

static void count(const int kind, const double n, MPI_Datatype type)
{
  int size = 0;
  PMPI_Type_size(type, &size);
  calls[kind] += 1;
  bytes[kind] += n * size;
}

static int n_ranks(MPI_Comm c)
{
  int n = 1;
  PMPI_Comm_size(c, &n);
  return n;
}

static double sum(const int *n, MPI_Comm c)
{
  double s = 0;
  for (int i = 0; i < n_ranks(c); ++i)
    s += n[i];
  return s;
}

#define SEND(NAME, ...) \
  { count(sends, n, t); return P##NAME(b, n, t, to, tag, c, ##__VA_ARGS__); }
int MPI_Send(const void *b, int n, MPI_Datatype t, int to, int tag, MPI_Comm c) SEND(MPI_Send)
int MPI_Ssend(const void *b, int n, MPI_Datatype t, int to, int tag, MPI_Comm c) SEND(MPI_Ssend)
int MPI_Rsend(const void *b, int n, MPI_Datatype t, int to, int tag, MPI_Comm c) SEND(MPI_Rsend)
int MPI_Isend(const void *b, int n, MPI_Datatype t, int to, int tag, MPI_Comm c, MPI_Request *r) SEND(MPI_Isend, r)
int MPI_Issend(const void *b, int n, MPI_Datatype t, int to, int tag, MPI_Comm c, MPI_Request *r) SEND(MPI_Issend, r)
int MPI_Irsend(const void *b, int n, MPI_Datatype t, int to, int tag, MPI_Comm c, MPI_Request *r) SEND(MPI_Irsend, r)

int MPI_Allreduce(const void *a, void *b, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c)
{
  count(reductions, n, t);
  return PMPI_Allreduce(a, b, n, t, o, c);
}
int MPI_Reduce(const void *a, void *b, int n, MPI_Datatype t, MPI_Op o, int root, MPI_Comm c)
{
  count(reductions, n, t);
  return PMPI_Reduce(a, b, n, t, o, root, c);
}
int MPI_Reduce_scatter(const void *a, void *b, const int *n, MPI_Datatype t, MPI_Op o, MPI_Comm c)
{
  count(reductions, sum(n, c), t);
  return PMPI_Reduce_scatter(a, b, n, t, o, c);
}
int MPI_Reduce_scatter_block(const void *a, void *b, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c)
{
  count(reductions, (double)n * n_ranks(c), t);
  return PMPI_Reduce_scatter_block(a, b, n, t, o, c);
}
int MPI_Allgather(const void *a, int n, MPI_Datatype t, void *b, int m, MPI_Datatype u, MPI_Comm c)
{
  count(gathers, (double)m * n_ranks(c), u);
  return PMPI_Allgather(a, n, t, b, m, u, c);
}
int MPI_Allgatherv(const void *a, int n, MPI_Datatype t, void *b, const int *m, const int *d, MPI_Datatype u, MPI_Comm c)
{
  count(gathers, sum(m, c), u);
  return PMPI_Allgatherv(a, n, t, b, m, d, u, c);
}
int MPI_Gather(const void *a, int n, MPI_Datatype t, void *b, int m, MPI_Datatype u, int root, MPI_Comm c)
{
  count(gathers, n, t);
  return PMPI_Gather(a, n, t, b, m, u, root, c);
}
int MPI_Gatherv(const void *a, int n, MPI_Datatype t, void *b, const int *m, const int *d, MPI_Datatype u, int root,
                MPI_Comm c)
{
  count(gathers, n, t);
  return PMPI_Gatherv(a, n, t, b, m, d, u, root, c);
}
int MPI_Alltoall(const void *a, int n, MPI_Datatype t, void *b, int m, MPI_Datatype u, MPI_Comm c)
{
  count(all_to_alls, (double)m * n_ranks(c), u);
  return PMPI_Alltoall(a, n, t, b, m, u, c);
}
int MPI_Alltoallv(const void *a, const int *n, const int *e, MPI_Datatype t, void *b, const int *m, const int *d,
                  MPI_Datatype u, MPI_Comm c)
{
  count(all_to_alls, sum(n, c), t);
  return PMPI_Alltoallv(a, n, e, t, b, m, d, u, c);
}
int MPI_Bcast(void *b, int n, MPI_Datatype t, int root, MPI_Comm c)
{
  count(broadcasts, n, t);
  return PMPI_Bcast(b, n, t, root, c);
}
int MPI_Barrier(MPI_Comm c)
{
  count(barriers, 0, MPI_BYTE);
  return PMPI_Barrier(c);
}
int MPI_Ibarrier(MPI_Comm c, MPI_Request *r)
{
  count(barriers, 0, MPI_BYTE);
  return PMPI_Ibarrier(c, r);
}
int MPI_Scan(const void *a, void *b, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c)
{
  count(scans, n, t);
  return PMPI_Scan(a, b, n, t, o, c);
}
int MPI_Exscan(const void *a, void *b, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c)
{
  count(scans, n, t);
  return PMPI_Exscan(a, b, n, t, o, c);
}

int MPI_Finalize(void)
{
  double own[2 * n_kinds], total[2 * n_kinds], largest[2 * n_kinds];
  memcpy(own, calls, sizeof calls);
  memcpy(own + n_kinds, bytes, sizeof bytes);
  PMPI_Reduce(own, total, 2 * n_kinds, MPI_DOUBLE, MPI_SUM, 0, MPI_COMM_WORLD);
  PMPI_Reduce(own, largest, 2 * n_kinds, MPI_DOUBLE, MPI_MAX, 0, MPI_COMM_WORLD);
  int rank = 0;
  PMPI_Comm_rank(MPI_COMM_WORLD, &rank);
  const int n = n_ranks(MPI_COMM_WORLD);
  if (rank == 0)
    for (int k = 0; k < n_kinds; ++k)
      fprintf(stderr, "messages | %d | %s | %.0f | %.0f | %.0f | %.0f\n", n, name[k], total[k] / n, largest[k],
              total[n_kinds + k] / n, largest[n_kinds + k]);
  return PMPI_Finalize();
}
