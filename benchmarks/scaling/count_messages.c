/* Counts what a program sends between ranks, through the profiling interface of MPI (MPI 3.1, chapter 14).
 *
 *   mpicc -shared -fPIC -O2 -o libcount.so count_messages.c
 *   COUNT_MESSAGES=FOLDER LD_PRELOAD=./libcount.so mpirun -n 4 PROGRAM
 *
 * Each rank writes FOLDER/rank-R.json when MPI ends: messages, bytes and partners of its point-to-point messages; calls
 * and bytes of collectives by name; its largest memory in kB. Bytes of a collective are what the rank gives plus what
 * it takes. */
#define _GNU_SOURCE
#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

enum { n_kinds = 11 };
static const char *const names[n_kinds] = {"allreduce", "reduce",  "broadcast", "gather", "allgather", "alltoall",
                                           "scan",      "barrier", "scatter",   "reduce_scatter", "split"};
enum kind { allreduce, reduce, broadcast, gather, allgather, alltoall, scan, barrier, scatter, reduce_scatter, split, other };

static long long messages, message_bytes, calls[n_kinds], bytes[n_kinds];
static unsigned char *partner;

static long long size_of(int count, MPI_Datatype type)
{
  int size = 0;
  PMPI_Type_size(type, &size);
  return (long long)count * size;
}

static int ranks(MPI_Comm communicator)
{
  int size = 1;
  PMPI_Comm_size(communicator, &size);
  return size;
}

static int rank_in(MPI_Comm communicator)
{
  int rank = 0;
  PMPI_Comm_rank(communicator, &rank);
  return rank;
}

static void count_message(int count, MPI_Datatype type, int to, MPI_Comm communicator)
{
  if (to == MPI_PROC_NULL)
    return;
  ++messages;
  message_bytes += size_of(count, type);
  if (!partner)
    partner = calloc(ranks(MPI_COMM_WORLD), 1);
  MPI_Group here, world;
  int in_world = 0;
  PMPI_Comm_group(communicator, &here);
  PMPI_Comm_group(MPI_COMM_WORLD, &world);
  PMPI_Group_translate_ranks(here, 1, &to, world, &in_world);
  PMPI_Group_free(&here);
  PMPI_Group_free(&world);
  if (in_world >= 0)
    partner[in_world] = 1;
}

static void count_call(enum kind kind, long long n_bytes, MPI_Comm communicator)
{
  if (ranks(communicator) == 1)
    return;
  ++calls[kind];
  bytes[kind] += n_bytes;
}

static long long sum(const int counts[], int n)
{
  long long total = 0;
  for (int i = 0; i < n; ++i)
    total += counts[i];
  return total;
}

#define COUNTED_SEND(name)                                                                                             \
  int MPI_##name(const void *data, int count, MPI_Datatype type, int to, int tag, MPI_Comm communicator)               \
  {                                                                                                                    \
    count_message(count, type, to, communicator);                                                                      \
    return PMPI_##name(data, count, type, to, tag, communicator);                                                      \
  }
COUNTED_SEND(Send)
COUNTED_SEND(Ssend)
COUNTED_SEND(Rsend)
COUNTED_SEND(Bsend)

#define COUNTED_START(name)                                                                                            \
  int MPI_##name(const void *data, int count, MPI_Datatype type, int to, int tag, MPI_Comm communicator,               \
                 MPI_Request *request)                                                                                 \
  {                                                                                                                    \
    count_message(count, type, to, communicator);                                                                      \
    return PMPI_##name(data, count, type, to, tag, communicator, request);                                             \
  }
COUNTED_START(Isend)
COUNTED_START(Issend)
COUNTED_START(Irsend)

int MPI_Sendrecv(const void *out, int n_out, MPI_Datatype out_type, int to, int out_tag, void *in, int n_in,
                 MPI_Datatype in_type, int from, int in_tag, MPI_Comm communicator, MPI_Status *status)
{
  count_message(n_out, out_type, to, communicator);
  return PMPI_Sendrecv(out, n_out, out_type, to, out_tag, in, n_in, in_type, from, in_tag, communicator, status);
}

int MPI_Allreduce(const void *out, void *in, int n, MPI_Datatype type, MPI_Op operation, MPI_Comm communicator)
{
  count_call(allreduce, 2 * size_of(n, type), communicator);
  return PMPI_Allreduce(out, in, n, type, operation, communicator);
}

int MPI_Iallreduce(const void *out, void *in, int n, MPI_Datatype type, MPI_Op operation, MPI_Comm communicator,
                   MPI_Request *request)
{
  count_call(allreduce, 2 * size_of(n, type), communicator);
  return PMPI_Iallreduce(out, in, n, type, operation, communicator, request);
}

int MPI_Reduce(const void *out, void *in, int n, MPI_Datatype type, MPI_Op operation, int root, MPI_Comm communicator)
{
  count_call(reduce, size_of(n, type), communicator);
  return PMPI_Reduce(out, in, n, type, operation, root, communicator);
}

int MPI_Bcast(void *data, int n, MPI_Datatype type, int root, MPI_Comm communicator)
{
  count_call(broadcast, size_of(n, type), communicator);
  return PMPI_Bcast(data, n, type, root, communicator);
}

int MPI_Gather(const void *out, int n_out, MPI_Datatype out_type, void *in, int n_in, MPI_Datatype in_type, int root,
               MPI_Comm communicator)
{
  count_call(gather, size_of(n_out, out_type) +
                         (rank_in(communicator) == root ? ranks(communicator) * size_of(n_in, in_type) : 0),
             communicator);
  return PMPI_Gather(out, n_out, out_type, in, n_in, in_type, root, communicator);
}

int MPI_Gatherv(const void *out, int n_out, MPI_Datatype out_type, void *in, const int n_in[], const int begin[],
                MPI_Datatype in_type, int root, MPI_Comm communicator)
{
  count_call(gather, size_of(n_out, out_type) +
                         (rank_in(communicator) == root ? sum(n_in, ranks(communicator)) * size_of(1, in_type) : 0),
             communicator);
  return PMPI_Gatherv(out, n_out, out_type, in, n_in, begin, in_type, root, communicator);
}

int MPI_Scatter(const void *out, int n_out, MPI_Datatype out_type, void *in, int n_in, MPI_Datatype in_type, int root,
                MPI_Comm communicator)
{
  count_call(scatter, size_of(n_in, in_type), communicator);
  return PMPI_Scatter(out, n_out, out_type, in, n_in, in_type, root, communicator);
}

int MPI_Allgather(const void *out, int n_out, MPI_Datatype out_type, void *in, int n_in, MPI_Datatype in_type,
                  MPI_Comm communicator)
{
  count_call(allgather, (ranks(communicator) + 1) * size_of(n_in, in_type), communicator);
  return PMPI_Allgather(out, n_out, out_type, in, n_in, in_type, communicator);
}

int MPI_Iallgather(const void *out, int n_out, MPI_Datatype out_type, void *in, int n_in, MPI_Datatype in_type,
                   MPI_Comm communicator, MPI_Request *request)
{
  count_call(allgather, (ranks(communicator) + 1) * size_of(n_in, in_type), communicator);
  return PMPI_Iallgather(out, n_out, out_type, in, n_in, in_type, communicator, request);
}

int MPI_Allgatherv(const void *out, int n_out, MPI_Datatype out_type, void *in, const int n_in[], const int begin[],
                   MPI_Datatype in_type, MPI_Comm communicator)
{
  count_call(allgather, (sum(n_in, ranks(communicator)) + n_out) * size_of(1, in_type), communicator);
  return PMPI_Allgatherv(out, n_out, out_type, in, n_in, begin, in_type, communicator);
}

int MPI_Alltoall(const void *out, int n_out, MPI_Datatype out_type, void *in, int n_in, MPI_Datatype in_type,
                 MPI_Comm communicator)
{
  count_call(alltoall, 2 * ranks(communicator) * size_of(n_in, in_type), communicator);
  return PMPI_Alltoall(out, n_out, out_type, in, n_in, in_type, communicator);
}

int MPI_Alltoallv(const void *out, const int n_out[], const int out_begin[], MPI_Datatype out_type, void *in,
                  const int n_in[], const int in_begin[], MPI_Datatype in_type, MPI_Comm communicator)
{
  const int n = ranks(communicator);
  count_call(alltoall, sum(n_out, n) * size_of(1, out_type) + sum(n_in, n) * size_of(1, in_type), communicator);
  return PMPI_Alltoallv(out, n_out, out_begin, out_type, in, n_in, in_begin, in_type, communicator);
}

int MPI_Scan(const void *out, void *in, int n, MPI_Datatype type, MPI_Op operation, MPI_Comm communicator)
{
  count_call(scan, 2 * size_of(n, type), communicator);
  return PMPI_Scan(out, in, n, type, operation, communicator);
}

int MPI_Exscan(const void *out, void *in, int n, MPI_Datatype type, MPI_Op operation, MPI_Comm communicator)
{
  count_call(scan, 2 * size_of(n, type), communicator);
  return PMPI_Exscan(out, in, n, type, operation, communicator);
}

int MPI_Reduce_scatter(const void *out, void *in, const int n[], MPI_Datatype type, MPI_Op operation,
                       MPI_Comm communicator)
{
  count_call(reduce_scatter, sum(n, ranks(communicator)) * size_of(1, type), communicator);
  return PMPI_Reduce_scatter(out, in, n, type, operation, communicator);
}

int MPI_Reduce_scatter_block(const void *out, void *in, int n, MPI_Datatype type, MPI_Op operation,
                             MPI_Comm communicator)
{
  count_call(reduce_scatter, (ranks(communicator) + 1) * size_of(n, type), communicator);
  return PMPI_Reduce_scatter_block(out, in, n, type, operation, communicator);
}

int MPI_Barrier(MPI_Comm communicator)
{
  count_call(barrier, 0, communicator);
  return PMPI_Barrier(communicator);
}

int MPI_Ibarrier(MPI_Comm communicator, MPI_Request *request)
{
  count_call(barrier, 0, communicator);
  return PMPI_Ibarrier(communicator, request);
}

int MPI_Comm_split(MPI_Comm communicator, int colour, int key, MPI_Comm *made)
{
  count_call(split, 0, communicator);
  return PMPI_Comm_split(communicator, colour, key, made);
}

int MPI_Comm_dup(MPI_Comm communicator, MPI_Comm *made)
{
  count_call(split, 0, communicator);
  return PMPI_Comm_dup(communicator, made);
}

int MPI_Comm_create(MPI_Comm communicator, MPI_Group group, MPI_Comm *made)
{
  count_call(split, 0, communicator);
  return PMPI_Comm_create(communicator, group, made);
}

int MPI_Finalize(void)
{
  const char *folder = getenv("COUNT_MESSAGES");
  if (folder)
  {
    char path[4096];
    snprintf(path, sizeof path, "%s/rank-%d.json", folder, rank_in(MPI_COMM_WORLD));
    FILE *file = fopen(path, "w");
    if (file)
    {
      int partners = 0;
      for (int r = 0; partner && r < ranks(MPI_COMM_WORLD); ++r)
        partners += partner[r];
      struct rusage usage;
      getrusage(RUSAGE_SELF, &usage);
      fprintf(file, "{\"messages\": %lld, \"bytes\": %lld, \"partners\": %d, \"memory\": %ld, \"collectives\": {",
              messages, message_bytes, partners, usage.ru_maxrss);
      for (int k = 0; k < n_kinds; ++k)
        fprintf(file, "%s\"%s\": [%lld, %lld]", k ? ", " : "", names[k], calls[k], bytes[k]);
      fprintf(file, "}}\n");
      fclose(file);
    }
  }
  return PMPI_Finalize();
}
