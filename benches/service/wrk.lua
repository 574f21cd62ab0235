-- A request from the environment, and the figures of a run as one line of JSON.
wrk.method = os.getenv("LOAD_METHOD") or "GET"
local body = os.getenv("LOAD_BODY")
if body then
  wrk.body = io.open(body, "rb"):read("*a")
  wrk.headers["Content-Type"] = "application/json"
end
wrk.headers["If-None-Match"] = os.getenv("LOAD_TAG")

function done(summary, latency)
  local errors = summary.errors
  io.write(string.format(
    'figures {"requests": %d, "us": %d, "p50_us": %d, "p99_us": %d, "failed": %d}\n',
    summary.requests, summary.duration, latency:percentile(50), latency:percentile(99),
    errors.connect + errors.read + errors.write + errors.status + errors.timeout))
end
