# raggio for the CPU: no window, no GPU. Nobody has built this file yet; the CI job "container" will be the first to.
#
#   docker build -t raggio .
#   docker run --rm --user "$(id -u):$(id -g)" -v "$PWD:/scenes" raggio render scene.toml -o picture.png

FROM rust:1.95-slim-bookworm AS build
RUN apt-get update \
    && apt-get install -y --no-install-recommends g++ python3 python3-venv \
    && rm -rf /var/lib/apt/lists/*
WORKDIR /raggio
# What installs slangc comes first, so that a change of the source does not download it again.
COPY Cargo.toml ./
COPY scripts ./scripts
RUN bash scripts/setup.sh
COPY . .
# All levels of instruction sets: the image runs on other processors than it was built on. The best is chosen at run time.
RUN CARGO_PROFILE_RELEASE_STRIP=symbols \
    cargo build --release --locked --package raggio-cli --bin raggio

FROM debian:bookworm-slim
RUN apt-get update \
    && apt-get install -y --no-install-recommends libstdc++6 \
    && rm -rf /var/lib/apt/lists/*
COPY --from=build /raggio/target/release/raggio /usr/local/bin/raggio
COPY --from=build /raggio/LICENSE-MIT /raggio/LICENSE-APACHE /usr/share/doc/raggio/
# Scenes are mounted here, and pictures are written beside them.
WORKDIR /scenes
ENTRYPOINT ["raggio"]
CMD ["--help"]
