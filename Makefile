# What to run while working, and before a commit. The folders of tests/ are the layers.

PYTEST = pytest -q -n 2 --dist worksteal

.PHONY: test-fast check lint test test-long thorough coverage

test-fast: ## unit tests
	$(PYTEST) tests/unit

check: lint ## everything but services, experiments and what a user does
	$(PYTEST) tests/unit tests/simulation

lint: ## style, types, layers
	ruff check .
	ruff format --check .
	mypy
	lint-imports

test: ## every layer, without what takes minutes
	$(PYTEST)

test-long: ## the demo and the quick form of the paper's experiments, with their goals
	pytest -q -m long -s

thorough: ## unit tests with many random examples, others at every run
	HYPOTHESIS_PROFILE=thorough $(PYTEST) tests/unit tests/simulation --timeout 1800

coverage: ## of every layer, without the processes that tests start
	$(PYTEST) --cov --cov-report=term:skip-covered
