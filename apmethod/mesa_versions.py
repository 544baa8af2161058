"""The one file that knows how Mesa's versions differ."""

import mesa


def stay_alive(model: mesa.Model) -> None:
    """Let a model be stepped again after its step has raised.

    Mesa 3.5 steps a model by an event that schedules the next one when it returns; when it
    raises, no later call of ``model.step`` does anything.  Mesa 3.3 needs no help.
    """
    schedule = getattr(model, "_default_schedule", None)
    if schedule is not None:
        schedule._schedule_next(model.time + 1.0)


def come_back(model: mesa.Model, agent: mesa.Agent) -> None:
    """Register an agent again that had left the model, under the id it had."""
    identity = agent.unique_id
    model.register_agent(agent)
    agent.unique_id = identity  # Mesa 3.5 has given it a new one
