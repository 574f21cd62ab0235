# A single static binary in an empty image: no shell, no libraries, no root.
FROM rust:1-slim-bookworm AS build
WORKDIR /strahl
COPY . .
# glibc linked in, rather than musl, for its faster allocator. With --target the flag leaves build scripts and
# procedural macros alone. Registry and target folder stay between builds; the binary has to leave that cache.
RUN --mount=type=cache,target=/usr/local/cargo/registry --mount=type=cache,target=/strahl/target \
    target="$(rustc -vV | sed -n 's/^host: //p')" && \
    RUSTFLAGS="-C target-feature=+crt-static" cargo build --release --locked --bin strahl --target "$target" && \
    cp "target/$target/release/strahl" /usr/local/bin/strahl
# An empty image has no folder that anybody could write to. New volumes take their owner from these.
RUN mkdir -p /image/data /image/store /image/run/strahl/broker /image/run/strahl/front /image/run/strahl/node

FROM scratch
LABEL org.opencontainers.image.title="strahl" \
      org.opencontainers.image.description="Render service: a JSON scene in, a ray-traced picture and its cost out" \
      org.opencontainers.image.licenses="MIT OR Apache-2.0"
COPY --from=build /usr/local/bin/strahl /strahl
COPY --from=build --chown=65532:65532 /image/ /
# Object stores and webhooks are reached by https.
COPY --from=build /etc/ssl/certs/ca-certificates.crt /etc/ssl/certs/ca-certificates.crt
USER 65532:65532
# Jobs and their pictures: -v strahl:/data keeps them when the container goes.
ENV STRAHL_DATA=/data
VOLUME /data
EXPOSE 8080
STOPSIGNAL SIGTERM
# Inside the container only: it answers the health check however many clients there are. 0.0.0.0:9090 lets Prometheus in.
ENV STRAHL_ADMIN_LISTEN=127.0.0.1:9090
HEALTHCHECK --interval=10s --timeout=4s --start-period=2s CMD ["/strahl", "healthcheck"]
ENTRYPOINT ["/strahl"]
# The container's network keeps strangers out as long as its port is published to loopback only. To open it, give keys:
# docker run -v ./keys.toml:/keys.toml:ro -p 8080:8080 strahl serve --listen 0.0.0.0:8080 --keys /keys.toml
CMD ["serve", "--listen", "0.0.0.0:8080", "--insecure-no-auth"]
