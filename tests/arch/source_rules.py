#!/usr/bin/env python3
"""Words that have no place in flight code (fsw/, hal/). What the words stand for is checked again on the archives by
symbols.py; this check says so earlier and with a line number.

A line that needs an exception carries `// rule-exception: <rule>: <reason>`."""
import re

import common

LIBM = ("sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh exp exp2 expm1 log log2 log10 log1p pow hypot "
        "cbrt fmod remainder fma floor ceil round lround llround rint lrint nearbyint trunc erf tgamma lgamma").split()

RULES = {
    "exception": (r"\b(?:throw|try|catch)\b", "exceptions are off; return a Status"),
    "rtti": (r"\b(?:dynamic_cast|typeid)\b", "RTTI is off"),
    "heap": (r"\bnew\b(?!\s*\()|\bdelete\s*(?:\[\s*\]\s*)?\w|\b(?:malloc|calloc|realloc|free)\s*\(|"
             r"\bstd::(?:make_)?(?:unique|shared)(?:_ptr)?\b", "no heap"),
    "heap_container": (r"\bstd::(?:vector|string|deque|list|forward_list|map|set|multimap|multiset|unordered_\w+|function|any)\b",
                       "allocates; use a bounded container of fsw/base"),
    "dynamic_matrix": (r"\bEigen::(?:Matrix|Array|Vector|RowVector)X[a-z]?\w*", "allocates; give every dimension a maximum"),
    "stream": (r"\bstd::(?:cout|cerr|clog|cin|\w*stream|format|print)\b|\b(?:std::)?f?printf\s*\(", "no input or output here"),
    "clock": (r"\bstd::chrono\b|\b(?:clock_gettime|gettimeofday)\s*\(|\bstd::time\s*\(", "time comes from hal::Clock"),
    "random": (r"\bstd::(?:random_device|mt19937\w*|rand)\b|(?<![\w.>:])rand\s*\(", "use fsw/base/generator.hpp"),
    "libm": (r"\bstd::(?:" + "|".join(LIBM) + r")f?\s*\(|(?<![\w.>:])(?:" + "|".join(LIBM) + r")f\s*\(",
             "its bits differ between targets; use fsw/math"),
    "static_data": (r"^\s*(?:inline\s+)?(?:static|thread_local)\s+(?!.*\b(?:const|constexpr|consteval|constinit\s+const)\b)[^()]*[;={]",
                    "writable static data; keep it in an object"),
    "goto": (r"\bgoto\b", "no goto"),
}
PATTERNS = {rule: re.compile(pattern) for rule, (pattern, _) in RULES.items()}
EXCEPTION = re.compile(r"//\s*rule-exception:\s*(\w+):\s*\S")


def check(root):
    problems = []
    for path in common.sources(root, ["fsw", "hal"]):
        text = (root / path).read_text()
        for number, (line, code) in enumerate(zip(text.splitlines(), common.without_comments(text).splitlines()), 1):
            if code.lstrip().startswith("#"):
                continue
            excused = set(EXCEPTION.findall(line))
            for unknown in sorted(excused - set(RULES)):
                problems.append(f"{path}:{number}: exception for a rule that does not exist: {unknown}")
            for rule, pattern in PATTERNS.items():
                if rule not in excused and pattern.search(code):
                    problems.append(f"{path}:{number}: {rule}: {RULES[rule][1]}: {line.strip()}")
    return problems


def seed(rule, code):
    return common.Seed(f"{rule}: {code}", {"fsw/base/a.cpp": code + "\n"}, f"fsw/base/a.cpp:1: {rule}:")


SEEDS = [
    common.Seed("what is allowed", {"fsw/base/a.cpp": "\n".join([
        "// throw new std::vector, std::sin(x)", 'const char* text = "throw std::string goto";',
        "static constexpr double one = 1.0;", "static const int two = 2;", "static int helper(int value) { return value; }",
        "T& operator=(const T&) = delete;", "auto copy = new_value;", "double y = relnav::sin(x) + own::exp(x) + std::sqrt(x);",
        "::new (place) T;  // rule-exception: heap: placement, takes no memory", "static auto f() -> int;",
        "  static_assert(sizeof(int) == 4);", "x = filter.log(2) + sin(y) + 1'000'000;", ""])}, None),
    seed("exception", "void f() { throw 1; }"),
    seed("rtti", "auto* d = dynamic_cast<D*>(b);"),
    seed("heap", "int* p = new int;"),
    seed("heap", "delete p;"),
    seed("heap", "void* p = std::malloc(3);"),
    seed("heap", "std::unique_ptr<int> p;"),
    seed("heap_container", "std::vector<int> v;"),
    seed("heap_container", "std::string s;"),
    seed("dynamic_matrix", "Eigen::MatrixXd m(3, 3);"),
    seed("stream", "std::cout << 1;"),
    seed("stream", 'std::printf("x");'),
    seed("clock", "auto t = std::chrono::steady_clock::now();"),
    seed("random", "std::mt19937 g;"),
    seed("libm", "double y = std::sin(x);"),
    seed("libm", "float y = cosf(x);"),
    seed("static_data", "  static int counter = 0;"),
    seed("static_data", "static Filter filter;"),
    seed("static_data", "  static std::array<double, 9> scratch{};"),
    seed("goto", "goto out;"),
    common.Seed("exception for nothing", {"hal/a.hpp": "int x;  // rule-exception: nonsense: because\n"}, "does not exist"),
]

if __name__ == "__main__":
    common.main(__doc__, check, SEEDS)
