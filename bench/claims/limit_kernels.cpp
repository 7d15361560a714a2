// What one core of this machine can do, for limit.py: lines read from a buffer, lane instructions done.
//
// Each function does a given amount of work and returns something that depends on all of it; the clock is in limit.py.
#include <cstdint>
#include <cstdlib>
#include <cstring>
#ifdef __linux__
#include <sys/mman.h>
#endif

namespace {

constexpr std::size_t LINE = 64;
constexpr std::size_t LARGE_PAGE = 1 << 21;

typedef float Lanes __attribute__((vector_size(64)));
typedef std::uint64_t Words __attribute__((vector_size(64)));

// A number that looks random, made of its place alone: no read has to wait for the one before.
inline std::uint64_t mixed(std::uint64_t i) {
    i *= 0x9e3779b97f4a7c15u;
    i ^= i >> 29;
    i *= 0xbf58476d1ce4e5b9u;
    return i ^ i >> 32;
}

// One of `lines`, fewer than 2^32.
inline std::uint64_t line_of(std::uint64_t random, std::uint64_t lines) { return (random >> 32) * lines >> 32; }

}  // namespace

extern "C" {

// A buffer of zeros, in ordinary or in huge pages (where the system has them); null where there is no memory.
char *limit_buffer(std::size_t bytes, int huge) {
    bytes = (bytes + LARGE_PAGE - 1) / LARGE_PAGE * LARGE_PAGE;
    char *buffer = static_cast<char *>(std::aligned_alloc(LARGE_PAGE, bytes));
    if (!buffer) return nullptr;
#ifdef __linux__
    madvise(buffer, bytes, huge ? MADV_HUGEPAGE : MADV_NOHUGEPAGE);
#endif
    std::memset(buffer, 0, bytes);
    return buffer;
}

void limit_free(char *buffer) { std::free(buffer); }

// Lines at random places, as many in flight as the core can.
std::uint64_t limit_random(const char *buffer, std::uint64_t lines, std::uint64_t count, std::uint64_t from) {
    std::uint64_t sum = 0;
    for (std::uint64_t i = from; i < from + count; i++)
        sum += *reinterpret_cast<const std::uint64_t *>(buffer + LINE * line_of(mixed(i), lines));
    return sum;
}

// The same, each place known only when the line before has come.
std::uint64_t limit_chained(const char *buffer, std::uint64_t lines, std::uint64_t count, std::uint64_t from) {
    std::uint64_t sum = from;
    for (std::uint64_t i = 0; i < count; i++)
        sum = mixed(sum + 1 + *reinterpret_cast<const std::uint64_t *>(buffer + LINE * line_of(sum, lines)));
    return sum;
}

// All lines one after the other, `count` in all.
std::uint64_t limit_sequential(const char *buffer, std::uint64_t lines, std::uint64_t count, std::uint64_t) {
    Words sum[4] = {};
    for (std::uint64_t done = 0; done < count; done += lines)
        for (std::uint64_t i = 0; i + 4 <= lines; i += 4)
            for (int k = 0; k < 4; k++) sum[k] += *reinterpret_cast<const Words *>(buffer + LINE * (i + k));
    const Words all = sum[0] + sum[1] + sum[2] + sum[3];
    return all[0] + all[1] + all[2] + all[3] + all[4] + all[5] + all[6] + all[7];
}

// `count` times 8 multiply-adds on 16 lanes, none waiting for its neighbours.
double limit_multiply_adds(std::uint64_t count) {
    Lanes x[8], a, b;
    for (int i = 0; i < 16; i++) {
        a[i] = 0.999f + 1e-4f * static_cast<float>(i);
        b[i] = 1e-3f;
        for (int k = 0; k < 8; k++) x[k][i] = static_cast<float>(i + k);
    }
    for (std::uint64_t n = 0; n < count; n++)
        for (int k = 0; k < 8; k++) x[k] = x[k] * a + b;
    double sum = 0.0;
    for (int k = 0; k < 8; k++)
        for (int i = 0; i < 16; i++) sum += x[k][i];
    return sum;
}

// `count` times 8 multiply-adds and 8 sums on 16 lanes: cores with units for each do both at once.
double limit_mixed(std::uint64_t count) {
    Lanes x[8], y[8], a, b;
    for (int i = 0; i < 16; i++) {
        a[i] = 0.999f + 1e-4f * static_cast<float>(i);
        b[i] = 1e-3f;
        for (int k = 0; k < 8; k++) x[k][i] = y[k][i] = static_cast<float>(i + k);
    }
    for (std::uint64_t n = 0; n < count; n++)
        for (int k = 0; k < 8; k++) {
            x[k] = x[k] * a + b;
            y[k] = y[k] + b;
        }
    double sum = 0.0;
    for (int k = 0; k < 8; k++)
        for (int i = 0; i < 16; i++) sum += x[k][i] + y[k][i];
    return sum;
}
}
